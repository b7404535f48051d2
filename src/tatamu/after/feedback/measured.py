"""The measurement of one real fold, by a ruler or from a photograph."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.errors import InputError
from tatamu.base.files import read_toml, validated
from tatamu.base.records import OpenRecord, Record
from tatamu.folding.fold import Fold
from tatamu.folding.score import MARKS
from tatamu.simulation.material import Number

RULER = 0.0015
"""Standard deviation of a number that was read from a ruler [m]."""
MAX_LENGTH = 2.0
"""Largest deviation in a file [m]."""
PLACES = ("left", "right", "slip")
"""What a person measures, each along the fold and across it."""
RULER_SOURCE = "ruler"

Side = Literal["left", "right"]


class MeasuredNumber(OpenRecord):
    """One measured number."""

    name: str
    """Name of the number, from `folding.score.MARKS`."""
    value: Annotated[Number, Field(ge=-MAX_LENGTH, le=MAX_LENGTH)]
    """Deviation from the target [m]."""
    deviation: Annotated[Number, Field(gt=0.0, le=MAX_LENGTH)]
    """Standard deviation of the measurement [m]."""

    @model_validator(mode="after")
    def _check(self) -> MeasuredNumber:
        if self.name not in MARKS:
            raise ValueError(f"name must be one of {', '.join(MARKS)}, given {self.name!r}")
        return self


class MeasuredFold(OpenRecord):
    """The contents of `observed/N.json`: where one real fold ended."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"turned_in"})

    version: Literal[1] = 1
    measured: list[MeasuredNumber]
    held: bool
    """Whether the fold succeeded."""
    source: str
    """"ruler", or the digest of the photograph from which the numbers were read."""
    turned_in: list[Side] = Field(default_factory=list)
    """Corners of the hem that are turned in. They are not measured."""

    @model_validator(mode="after")
    def _check(self) -> MeasuredFold:
        names = [number.name for number in self.measured]
        if len(set(names)) < len(names):
            raise ValueError(f"measured must not contain the same name twice, given {', '.join(names)}")
        for side in self.turned_in:
            if any(name.startswith(side) for name in names):
                raise ValueError(
                    f"turned_in must not contain {side}, because numbers are given for this corner; leave out the "
                    "numbers or the corner"
                )
        if not names and self.held:
            raise ValueError("at least one measured number is needed, unless the fold failed")
        return self


class Template(Record):
    """The form that a person fills in, see `FORM`. Lengths are in millimetres."""

    left: Annotated[list[Number], Field(min_length=2, max_length=2)] | None = None
    right: Annotated[list[Number], Field(min_length=2, max_length=2)] | None = None
    slip: Annotated[list[Number], Field(min_length=2, max_length=2)] | None = None
    deviation: Annotated[Number, Field(gt=0.0, le=100.0)] = 1e3 * RULER
    turned_in: list[Side] = Field(default_factory=list)
    failed: Annotated[bool, Field(strict=True)] = False


FORM = """# After the fold: where did it end? Lengths in millimetres; delete what you did not measure.
# Along: in the direction in which the hem was carried; too far is positive.
# Across: towards the left hand is positive.

left = [0.0, 0.0]      # left corner of the moved hem from its target: along, across
right = [0.0, 0.0]     # right corner
slip = [0.0, 0.0]      # how far the lower hem has moved from where it lay
deviation = 1.5        # how far your numbers may be wrong (one standard deviation)
turned_in = []         # corners that are turned in: ["left"], ["right"]; delete their numbers above
failed = false         # true if nothing can be measured
"""
"""The form that `tatamu observe --template` writes."""


def read_template(path: Path, size: float) -> MeasuredFold:
    """Read a form that was filled in, for a cloth of a size [m]."""
    form = validated(Template, read_toml(path), path)
    given = {place: pair for place in PLACES if (pair := getattr(form, place)) is not None}
    try:
        return ruler(given, size, unit="mm", deviation=form.deviation, failed=form.failed, turned_in=form.turned_in)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def size_of(fold: Fold) -> float:
    """Return the largest extent of the flat cloth [m]. Larger measured numbers probably have a wrong unit."""
    return float(np.ptp(fold.start[:, :2], axis=0).max())


def ruler(
    pairs: Mapping[str, Sequence[float]],
    size: float,
    *,
    label: str = "{}",
    unit: Literal["m", "mm"] = "m",
    deviation: float | None = None,
    failed: bool = False,
    turned_in: Sequence[str] = (),
) -> MeasuredFold:
    """Return the fold that a person measured with a ruler.

    Args:
        pairs: For each name in `PLACES`, the deviations along the fold and across it, in `unit`.
        size: Size of the cloth [m], see `size_of`.
        label: How messages name a place, as a format such as "--{}".
        unit: Unit of all numbers.
        deviation: Standard deviation of each number, in `unit`; None for 1.5 mm.
        failed: Whether the fold failed.
        turned_in: Corners of the hem that are turned in.

    Raises:
        InputError: If a number is out of range, or none is given although the fold did not fail.
    """
    scale = 1.0 if unit == "m" else 1e-3
    error = RULER if deviation is None else scale * deviation
    if not 0.0 < error <= MAX_LENGTH:
        limit = f"must be above 0 and at most {MAX_LENGTH / scale:g} {unit}"
        raise InputError(f"{label.format('deviation')}: {limit}, given {deviation}")
    for place, pair in pairs.items():
        given = list(pair) if isinstance(pair, Iterable) else [pair]
        if len(given) != 2 or not all(isinstance(value, Real) and scale * abs(value) <= size for value in given):
            raise InputError(
                f"{label.format(place)}: must be two numbers from {-size / scale:.3g} to {size / scale:.3g} {unit} "
                f"(the size of the cloth), given {', '.join(map(str, given))}; the first is along the fold, the second "
                "across it"
            )
    numbers = {
        f"{place}_{axis}": (scale * value, error)
        for place, pair in pairs.items()
        for axis, value in zip(("along", "across"), pair, strict=True)
    }
    return from_numbers(numbers, source=RULER_SOURCE, failed=failed, turned_in=turned_in)


def from_numbers(
    numbers: Mapping[str, tuple[float, float]], *, source: str, failed: bool = False, turned_in: Sequence[str] = ()
) -> MeasuredFold:
    """Return the fold with measured numbers, for example from a photograph.

    Args:
        numbers: For each measured name in `folding.score.MARKS`, the value and its standard deviation [m].
        source: "ruler", or the digest of the photograph.
        failed: Whether the fold failed.
        turned_in: Corners of the hem that are turned in.
    """
    plain: dict[str, Any] = {
        "measured": [{"name": name, "value": v, "deviation": d} for name, (v, d) in numbers.items()],
        "held": not failed,
        "source": source,
        "turned_in": list(turned_in),
    }
    return validated(MeasuredFold, plain, "measured")
