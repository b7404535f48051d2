"""Measures cloth on a table in photographs.

A printed board next to the cloth gives the scale. A photograph shows where the cloth lies, or how a fold ended.
"""
