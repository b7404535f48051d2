"""Folding: the wanted shape, the hands that reach for it, and how well they did."""
