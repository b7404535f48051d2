"""Elastic forces of a sheet: membrane with tension field, bending by dihedral angles, and the steps that they allow."""
