"""Learning a fold: a study of trials, and the folder that it fills."""

from tatamu.learning.learn import Progress, learn

__all__ = ["Progress", "learn"]
