"""Learning folds: a study of trials for each, and the folders that they fill."""

from tatamu.learning.job import learn_job
from tatamu.learning.learn import learn
from tatamu.learning.runner import Progress

__all__ = ["Progress", "learn", "learn_job"]
