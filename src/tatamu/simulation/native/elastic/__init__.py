"""Elastic forces of a sheet, and the time steps that they allow."""
