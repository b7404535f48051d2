"""Folding: the target shape, the manipulation that produces it, and the score of the result."""
