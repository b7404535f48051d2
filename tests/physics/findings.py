"""The findings of a check: rows for a table and curves for a figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Row:
    """One measured quantity, compared with its reference value."""

    quantity: str
    """Measured quantity with its unit in brackets."""
    reference: float | None
    """Reference value; None if the quantity should be as small as possible."""
    got: float
    """Measured value."""
    error: float
    """Error in `unit`. It is compared with `limit`."""
    limit: float | None
    """Largest allowed error in `unit`; None if the error is only reported."""
    unit: str
    """Unit of the error and of the limit."""
    note: str = ""
    """Additional remarks in one line."""

    @property
    def passed(self) -> bool | None:
        """Whether the error is within its limit; None if there is no limit. NaN is not within any limit."""
        return None if self.limit is None else bool(self.error <= self.limit)


@dataclass(frozen=True)
class Curve:
    """One line or one set of points in a figure of the page."""

    figure: str
    """Key of the figure that contains the curve."""
    name: str
    """Name of the curve in the legend."""
    x: np.ndarray
    """Horizontal coordinates of the k points, shape (k,)."""
    y: np.ndarray
    """Vertical coordinates of the k points, shape (k,)."""
    reference: bool = False
    """Whether the curve shows reference values. Reference values are drawn as a line, measured values as points."""


def in_order(curves: Sequence[Curve]) -> Iterator[tuple[Curve, int, bool]]:
    """Yield curves as they are drawn, references first.

    With each comes the number of its name among measured ones, 0 for a reference, and whether the name is new.
    """
    names = list(dict.fromkeys(curve.name for curve in curves if not curve.reference))
    seen: set[str] = set()
    for curve in sorted(curves, key=lambda curve: not curve.reference):
        yield curve, 0 if curve.reference else names.index(curve.name), curve.name not in seen
        seen.add(curve.name)


@dataclass(frozen=True)
class Figure:
    """Axes in which the curves of a check are drawn."""

    title: str
    x: str
    """Label of the horizontal axis, with its unit."""
    y: str
    """Label of the vertical axis, with its unit."""
    equal: bool = False
    """Whether both axes have the same scale."""
    log: bool = False
    """Whether both axes are logarithmic."""
    joined: bool = False
    """Whether the measured points are joined by lines."""


Finding = Row | Curve
Findings = Iterator[Finding]


def relative(quantity: str, reference: float, got: float, limit: float | None, note: str = "") -> Row:
    """Return a row whose error is |got / reference - 1| in per cent. `limit` is a fraction."""
    error = 100 * abs(got - reference) / abs(reference)
    return Row(quantity, reference, got, error, None if limit is None else 100 * limit, "%", note)


def absolute(quantity: str, reference: float, got: float, limit: float | None, unit: str, note: str = "") -> Row:
    """Return a row whose error is |got - reference|. All values have the unit `unit`."""
    return Row(quantity, reference, got, abs(got - reference), limit, unit, note)


def small(quantity: str, got: float, limit: float | None, unit: str, note: str = "") -> Row:
    """Return a row for a quantity that should be zero. Its error is `got`."""
    return Row(quantity, None, got, got, limit, unit, note)
