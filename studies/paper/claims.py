"""The paper's claims about its results, checked on ours. Every answer is a number with its definition."""

from __future__ import annotations
