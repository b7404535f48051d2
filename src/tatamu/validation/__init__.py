"""Validation: comparison of a simulator with an ideal cloth.

A check builds scenes and reads rollouts; it does not depend on a simulator. docs/reference/checks.md lists the checks.
"""

from tatamu.validation.report import Report, validate
from tatamu.validation.subject import Subject

__all__ = ["Report", "Subject", "validate"]
