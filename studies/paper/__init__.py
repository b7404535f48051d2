"""Section VI of the paper repeated; everything that the paper leaves open is an option."""

from studies.paper.experiment import Choices, Study, run

__all__ = ["Choices", "Study", "run"]
