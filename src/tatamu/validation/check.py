"""A check of a simulator, divided into cases that run independently."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from tatamu.validation.findings import Figure, Findings
from tatamu.validation.subject import Subject


@dataclass(frozen=True)
class Case:
    """One scene, or a few that are read together."""

    label: str
    run: Callable[[Subject], Findings]
    quick: bool = True
    """Whether `--quick` runs the case."""


@dataclass(frozen=True)
class Check:
    """Cases under one name."""

    name: str
    """Name that `--only` takes."""
    title: str
    reference: str
    """Source of the reference, one line."""
    cases: tuple[Case, ...]
    figures: dict[str, Figure] = field(default_factory=dict)
    remark: str = ""
    """Remark on the page that explains a figure."""
