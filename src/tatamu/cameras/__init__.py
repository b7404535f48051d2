"""Measures cloth on a table in photographs; a printed board next to the cloth gives the scale."""
