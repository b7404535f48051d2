"""After the fold: its measurement, the inferred errors of the set-up, and the correction of the next fold."""

from tatamu.observation.correction import Correction, Expected
from tatamu.observation.folder import ObservedFolder
from tatamu.observation.measured import FORM, Observation, from_numbers, read_template, ruler
from tatamu.observation.observe import Observed, corrected, observe, write_corrected
from tatamu.observation.posterior import Posterior

__all__ = [
    "FORM",
    "Correction",
    "Expected",
    "Observation",
    "Observed",
    "ObservedFolder",
    "Posterior",
    "corrected",
    "from_numbers",
    "observe",
    "read_template",
    "ruler",
    "write_corrected",
]
