"""The paper's experiment again: section VI, with what it leaves open as options."""

from tatamu.reproduction.experiment import Choices, Study, run

__all__ = ["Choices", "Study", "run"]
