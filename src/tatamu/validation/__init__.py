"""Validation: what a simulator does against what an ideal cloth does.

A check builds scenes and reads rollouts; it knows no simulator. docs/reference/checks.md lists the checks.
"""

from tatamu.validation.report import Report, validate
from tatamu.validation.subject import Subject

__all__ = ["Report", "Subject", "validate"]
