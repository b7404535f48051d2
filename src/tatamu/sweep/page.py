"""The page that compares the tasks of a sweep."""

from __future__ import annotations
