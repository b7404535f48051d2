"""Repeats the experiment of section VI of the paper that tatamu's method comes from.

Everything that the paper does not state is an option.
"""

from studies.paper.experiment import Choices, Study, run

__all__ = ["Choices", "Study", "run"]
