"""Elastic forces of a sheet, and the time steps that they allow.

The membrane forms a tension field when it wrinkles. Bending uses the dihedral angles between triangles.
"""
