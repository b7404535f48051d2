"""A check of a simulator. It consists of cases that run independently of each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from tests.physics.findings import Figure, Findings
from tests.physics.subject import Subject


@dataclass(frozen=True)
class Case:
    """Part of a check: one scene, or a few scenes, that are simulated and evaluated together."""

    label: str
    run: Callable[[Subject], Findings]
    quick: bool = True
    """Whether the option `--quick` runs the case too."""


@dataclass(frozen=True)
class Check:
    """A check of a simulator: a group of cases with a common name."""

    name: str
    """Name of the check, as given to the option `--only`."""
    title: str
    reference: str
    """Source of the reference values, in one line."""
    cases: tuple[Case, ...]
    figures: dict[str, Figure] = field(default_factory=dict)
    remark: str = ""
    """Explanation of the check's results, which the page shows; empty if there is none."""
