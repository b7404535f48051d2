"""Repeats the experiment of section VI of the paper. Everything that the paper does not state is an option."""

from studies.paper.experiment import Choices, Study, run

__all__ = ["Choices", "Study", "run"]
