"""Searches for the best parameters of trials.

The method `ask` returns the parameters of the next trial, and `tell` reports the result of a trial. A search uses only
vectors of numbers. It does not depend on cloth or on a simulator.
"""

from tatamu.search.registry import check_search, find_search, register_search, search_names
from tatamu.search.schedule import Schedule, Trials
from tatamu.search.search import HIGH, LOW, Observation, Proposal, Search
from tatamu.search.space import Bounds, Parameters, Space
from tatamu.search.two_fidelity import TwoFidelitySearch

__all__ = [
    "HIGH",
    "LOW",
    "Bounds",
    "Observation",
    "Parameters",
    "Proposal",
    "Schedule",
    "Search",
    "Space",
    "Trials",
    "TwoFidelitySearch",
    "check_search",
    "find_search",
    "register_search",
    "search_names",
]
