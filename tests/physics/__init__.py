"""Validation: comparison of a simulator with the theory of an ideal cloth.

A check makes scenes, which are the input of a simulation, and evaluates rollouts, which are the simulated motions. It
does not depend on a simulator. All checks are listed in docs/reference/checks.md.
"""

from tests.physics.report import Report, validate
from tests.physics.subject import Subject

__all__ = ["Report", "Subject", "validate"]
