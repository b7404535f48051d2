"""After a real fold: its measurement, the inferred errors of the set-up, and the correction of the next fold.

A set-up is one robot with one garment on one table. Its systematic errors are the same in every fold.
"""

from tatamu.after.feedback.correction import Correction, Expected, corrected
from tatamu.after.feedback.folder import FeedbackFolder, write_corrected
from tatamu.after.feedback.measured import FORM, MeasuredFold, from_numbers, read_template, ruler, size_of
from tatamu.after.feedback.observe import Feedback, feedback_of, observe
from tatamu.after.feedback.posterior import Posterior

__all__ = [
    "FORM",
    "Correction",
    "Expected",
    "Feedback",
    "FeedbackFolder",
    "MeasuredFold",
    "Posterior",
    "corrected",
    "feedback_of",
    "from_numbers",
    "observe",
    "read_template",
    "ruler",
    "size_of",
    "write_corrected",
]
