"""The version of tatamu."""

__version__ = "0.2.0"
