"""Measurements behind the figures of the documentation. `make help` lists them."""
