"""Handles the unit of length of a garment file, its metres and where it is stated, and the file's axes.

A wrong unit usually gives an unusual size, of which the user is warned, or which is refused if no garment has it. The
axes are turned to those of a garment: x points away from the hem, y to the left, z up.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tatamu.base.errors import InputError
from tatamu.garments.garment import MAX_SIDE, MIN_SIDE

NAMES = {1e-3: "millimetres", 1e-2: "centimetres", 0.0254: "inches", 0.1: "decimetres", 1.0: "metres"}
"""Names of units that are usual in drawings, by the length of the unit in metres."""
USUAL = (0.15, 1.8)
"""Range in which the longer side of most garments is [m]."""
DOUBTFUL = 2.6
"""Size of a garment [m] above which a note is given; apart from bed linen, hardly any is larger."""
Axis = Literal["x", "-x", "y", "-y", "z", "-z"]


@dataclass(frozen=True)
class Unit:
    """The unit of a file's coordinates."""

    metres: float
    """Length of one unit [m]."""
    name: str
    """Name of the unit in the plural."""
    source: str
    """Kind of file, and the words in it that state the unit."""
    given: bool = False
    """Whether the user gave the unit, which is then not doubted."""

    @property
    def words(self) -> str:
        """Text with the unit and its source, such as "read in millimetres (Inkscape SVG, width 620mm)"."""
        return f"read in {self.name} ({self.source})"

    def reading(self, size: tuple[float, float] | None) -> str:
        """Return `words`, and whether the garment is scaled to a size [m] that the user gave."""
        return f"{self.words}{'; scaled to that size' if size else ''}"

    def scaled(self, scale: float | None) -> Unit:
        """Return the unit with the length that the user gave [m], if any."""
        if scale is None:
            return self
        return Unit(scale, NAMES.get(scale, f"units of {scale:g} m"), f"scale {scale:g}", given=True)


def probable_scale(sides: tuple[float, float], unit: Unit, scales: Iterable[float] = NAMES) -> float | None:
    """Return the length [m] of another unit, out of `scales`, with which the sides [m] would have a usual size."""
    shorter, longer = (side / unit.metres for side in sorted(sides))
    fitting = [
        scale
        for scale in scales
        if USUAL[0] <= scale * longer <= USUAL[1] and scale * shorter >= MIN_SIDE and scale != unit.metres
    ]
    return min(fitting, key=lambda scale: abs(scale * longer - 0.7), default=None)


def how_to_scale(sides: tuple[float, float], unit: Unit) -> str:
    """Return advice on a size [m] that no garment has: a scale that helps, if there is one."""
    powers = [unit.metres * 10.0**power for power in (-3, -2, -1, 1, 2, 3)]
    scale = probable_scale(sides, unit) or probable_scale(sides, unit, powers)
    if scale is None:
        return ""
    how = f"give scale = {scale:g} under [garment] in a garment file, or --scale {scale:g}"
    return f"; {how} (metres per unit of the file)"


def check_size_of_file(sides: tuple[float, float], what: str, unit: Unit) -> None:
    """Refuse a width and length [m] that no garment has."""
    if MIN_SIDE <= min(sides) and max(sides) <= MAX_SIDE:
        return
    width, length = sides
    advice = how_to_scale(sides, unit) or "; no usual unit brings both sides into this range"
    raise InputError(
        f"{what}: each side must be from {MIN_SIDE:g} to {MAX_SIDE:g} m, given {width:.4g} x {length:.4g} m, "
        f"{unit.words}{advice}"
    )


def doubts(sides: tuple[float, float], unit: Unit) -> list[str]:
    """Return a note on an unusual width and length [m], unless the user gave the unit.

    Even a unit that the file states is doubted, because many programs write a wrong one into the header.
    """
    longest = max(sides)
    probable = probable_scale(sides, unit)
    if unit.given or probable is None or USUAL[0] <= longest <= DOUBTFUL:
        return []
    return [
        f"{longest:.2f} m is unusual for the longer side: is the file in {NAMES[probable]}? If so, give scale = "
        f"{probable:g} under [garment] in a garment file, or --scale {probable:g}"
    ]


def direction(axis: str) -> np.ndarray:
    """Return the unit vector along an axis of a file, such as -y, shape (3,)."""
    return (-1.0 if axis.startswith("-") else 1.0) * np.eye(3)["xyz".index(axis[-1])]


def plane_turn(up: str, grain: np.ndarray | None = None) -> np.ndarray:
    """Return the rotation of a file's x-y plane that turns `up`, or a grain line, to +x, shape (2, 2).

    A grain line that points away from `up` is reversed, but not one perpendicular to it.
    """
    ahead = direction(up)[:2]
    if grain is not None:
        along = float(grain @ ahead)
        ahead = grain if along >= -np.sin(np.radians(1.0)) else -grain
    return np.array([[ahead[0], ahead[1]], [-ahead[1], ahead[0]]])
