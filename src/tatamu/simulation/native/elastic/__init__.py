"""Elastic forces of a sheet, and the time steps that they allow.

The membrane can resist compression less than tension, because thin cloth wrinkles (tension field). Bending uses the
dihedral angles between triangles.
"""
