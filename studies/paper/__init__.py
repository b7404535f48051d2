"""Section VI of the paper once more, with what the paper leaves open as options."""

from studies.paper.experiment import Choices, Study, run

__all__ = ["Choices", "Study", "run"]
