"""A second opinion: a learned fold, simulated again in another simulator."""

from tatamu.after.second_opinion.check import Opinion, check

__all__ = ["Opinion", "check"]
