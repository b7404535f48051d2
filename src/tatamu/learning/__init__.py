"""Learning folds: a study of trials for each, and the folders that they fill."""

from tatamu.learning.expectation import USUAL_QUANTILE, Expectation
from tatamu.learning.job import as_begun, learn_job
from tatamu.learning.learn import learn
from tatamu.learning.runner import Progress

__all__ = ["USUAL_QUANTILE", "Expectation", "Progress", "as_begun", "learn", "learn_job"]
