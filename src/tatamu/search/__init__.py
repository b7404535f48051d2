"""Searches on vectors of numbers: `ask` returns the parameters of a trial, and `tell` reports how good they are."""

from tatamu.search.registry import check_search, find_search, register_search, search_names
from tatamu.search.search import Observation, Proposal, Search
from tatamu.search.space import Bounds, Parameters, Space

__all__ = [
    "Bounds",
    "Observation",
    "Parameters",
    "Proposal",
    "Search",
    "Space",
    "check_search",
    "find_search",
    "register_search",
    "search_names",
]
