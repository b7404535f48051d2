"""Findings of a check: rows of a table and curves of a plot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Row:
    """One measured quantity against its reference."""

    quantity: str
    """Measured quantity with its unit in brackets."""
    reference: float | None
    """Right value; None if it should be as small as possible."""
    got: float
    """Measured value."""
    error: float
    """Error, in `unit`, which is compared with `limit`."""
    limit: float | None
    """Largest allowed error, in `unit`; None if the row is stated, not judged."""
    unit: str
    """Unit of error and limit."""
    note: str = ""
    """Further remarks in one line."""

    @property
    def passed(self) -> bool | None:
        """Whether the error is within its limit (NaN is not); None without a limit."""
        return None if self.limit is None else bool(self.error <= self.limit)


@dataclass(frozen=True)
class Curve:
    """One line or cloud of points in a figure of the page."""

    figure: str
    """Key of the figure it belongs to."""
    name: str
    """Entry in the legend."""
    x: np.ndarray
    """Shape (k,)."""
    y: np.ndarray
    """Shape (k,)."""
    reference: bool = False
    """Drawn as a line of reference; measured curves are points."""


@dataclass(frozen=True)
class Figure:
    """Axes that the curves of a check are drawn in."""

    title: str
    x: str
    """Label with unit."""
    y: str
    """Label with unit."""
    equal: bool = False
    """Whether both axes have the same scale."""
    log: bool = False
    """Logarithmic axes."""
    joined: bool = False
    """Join the measured points by lines."""


Finding = Row | Curve
Findings = Iterator[Finding]


def relative(quantity: str, reference: float, got: float, limit: float | None, note: str = "") -> Row:
    """Make a row whose error is |got / reference - 1| in per cent; `limit` is a fraction."""
    error = 100 * abs(got - reference) / abs(reference)
    return Row(quantity, reference, got, error, None if limit is None else 100 * limit, "%", note)


def absolute(quantity: str, reference: float, got: float, limit: float | None, unit: str, note: str = "") -> Row:
    """Make a row whose error is |got - reference|; all in `unit`."""
    return Row(quantity, reference, got, abs(got - reference), limit, unit, note)


def small(quantity: str, got: float, limit: float | None, unit: str, note: str = "") -> Row:
    """Make a row for a quantity that should be zero; `got` itself is the error."""
    return Row(quantity, None, got, got, limit, unit, note)
