"""Photographs of cloth on a table: a printed board for scale, where the cloth lies, how a fold ended."""
