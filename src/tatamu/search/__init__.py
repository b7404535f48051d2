"""Searches on vectors of numbers: `ask` returns the parameters of a trial, and `tell` reports how good they are."""

from tatamu.search.search import Observation as Observation
from tatamu.search.search import Proposal as Proposal
from tatamu.search.search import Search as Search
from tatamu.search.search import check_search as check_search
from tatamu.search.search import find_search as find_search
from tatamu.search.search import register_search as register_search
from tatamu.search.search import search_names as search_names
from tatamu.search.space import Bounds as Bounds
from tatamu.search.space import Parameters as Parameters
from tatamu.search.space import Space as Space
