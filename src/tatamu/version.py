"""The version of tatamu."""

__version__ = "0.1.0"
