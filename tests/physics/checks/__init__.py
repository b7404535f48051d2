"""All checks by name, in the order in which they run."""

from __future__ import annotations

from tests.physics.check import Check
from tests.physics.checks import (
    air,
    bending,
    bodies,
    determinism,
    friction,
    hysteresis,
    motion,
    orthotropy,
    refinement,
    stack,
    stretch,
    symmetry,
    tangle,
)

FAMILIES = (
    motion,
    air,
    stretch,
    bending,
    orthotropy,
    hysteresis,
    friction,
    bodies,
    stack,
    tangle,
    refinement,
    symmetry,
    determinism,
)

CHECKS: dict[str, Check] = {check.name: check for family in FAMILIES for check in family.CHECKS}
"""Checks by their names, in the order in which they run."""
