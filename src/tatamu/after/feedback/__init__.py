"""After a real fold: its measurement, the inferred errors of the set-up, and the correction of the next fold.

A set-up is one robot with one garment on one table. Its systematic errors are the same in every fold. The prior is the
distribution of these errors before folds were observed. The posterior is their distribution after folds were observed.
"""

from tatamu.after.feedback.corrected import CorrectionRecord, corrected, keep, kept, write_corrected, write_kept
from tatamu.after.feedback.correction import Correction, Expected
from tatamu.after.feedback.folder import ObservedFolder
from tatamu.after.feedback.measured import FORM, Observation, from_numbers, read_template, ruler
from tatamu.after.feedback.observe import Observed, observe
from tatamu.after.feedback.posterior import Posterior

__all__ = [
    "FORM",
    "Correction",
    "CorrectionRecord",
    "Expected",
    "Observation",
    "Observed",
    "ObservedFolder",
    "Posterior",
    "corrected",
    "from_numbers",
    "keep",
    "kept",
    "observe",
    "read_template",
    "ruler",
    "write_corrected",
    "write_kept",
]
