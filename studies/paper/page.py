"""The page of the paper's experiment: its Fig. 5, Fig. 6, Tables I and II, medians over seeds, and its claims."""

from __future__ import annotations
