"""Handles the unit of length of a garment file.

For each file, tatamu records the length of the unit in metres, and the source of the unit, for example a word in the
file. A wrong unit usually gives the garment an unusual size. If the size is unusual, tatamu warns the user. If no
garment has such a size, tatamu refuses the file.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tatamu.base.errors import InputError
from tatamu.garments.resolution import LARGEST_SIDE, SMALLEST_SIDE

NAMES = {1e-3: "millimetres", 1e-2: "centimetres", 0.0254: "inches", 0.1: "decimetres", 1.0: "metres"}
"""Names of units that are usual in drawings, by the length of the unit in metres."""
USUAL = (0.15, 1.8)
"""Range in which the longer side of most garments is [m]."""
DOUBTFUL = 2.6
"""Largest size of a garment from a file that is accepted without a note [m].

Hardly any garment is larger, except for bed linen.
"""


@dataclass(frozen=True)
class Unit:
    """The unit of a file's coordinates."""

    metres: float
    """Length of one unit [m]."""
    name: str
    """Name of the unit in the plural."""
    source: str
    """Source of the unit: the kind of file, and the words in the file that state the unit."""
    given: bool = False
    """Whether the user gave the unit. A unit from the user is not doubted."""

    @property
    def words(self) -> str:
        """Text with the unit and its source, such as "read in millimetres (Inkscape SVG, width 620mm)"."""
        return f"read in {self.name} ({self.source})"

    def reading(self, size: tuple[float, float] | None) -> str:
        """Return the text of `words`.

        If the user gave a size [m], the text also says that the garment is scaled to this size.
        """
        return f"{self.words}{'; scaled to that size' if size else ''}"

    def scaled(self, scale: float | None) -> Unit:
        """Return a unit with the length `scale` [m] that the user gave; if `scale` is None, return this unit."""
        if scale is None:
            return self
        return Unit(scale, NAMES.get(scale, f"units of {scale:g} m"), f"scale {scale:g}", given=True)


def probable_scale(sides: tuple[float, float], unit: Unit, scales: Iterable[float] = NAMES) -> float | None:
    """Return the length [m] of another unit with which a garment has a usual size; None if no unit gives such a size.

    Args:
        sides: Width and length of the garment [m].
        unit: Unit in which the file was read.
        scales: Lengths of the units that may be meant [m].
    """
    shorter, longer = (side / unit.metres for side in sorted(sides))
    fitting = [
        scale
        for scale in scales
        if USUAL[0] <= scale * longer <= USUAL[1] and scale * shorter >= SMALLEST_SIDE and scale != unit.metres
    ]
    return min(fitting, key=lambda scale: abs(scale * longer - 0.7), default=None)


def how_to_scale(sides: tuple[float, float], unit: Unit) -> str:
    """Return advice on a size [m] that no garment has: a scale that helps, and nothing if there is no such scale."""
    powers = [unit.metres * 10.0**power for power in (-3, -2, -1, 1, 2, 3)]
    scale = probable_scale(sides, unit) or probable_scale(sides, unit, powers)
    if scale is None:
        return ""
    return (
        f"; give scale = {scale:g} under [garment] in a garment file, or --scale {scale:g}: metres per unit of the file"
    )


def check_size_of_file(sides: tuple[float, float], what: str, unit: Unit) -> None:
    """Refuse a width and length [m] that no garment has.

    Raises:
        InputError: If no garment is this large or this small.
    """
    if SMALLEST_SIDE <= min(sides) and max(sides) <= LARGEST_SIDE:
        return
    width, length = sides
    advice = how_to_scale(sides, unit)
    if not advice:
        small = min(sides) < SMALLEST_SIDE
        advice = f"; no usual unit makes it fit, and nothing that is {'narrower' if small else 'larger'} can be folded"
    raise InputError(
        f"{what}: must be from {SMALLEST_SIDE:g} to {LARGEST_SIDE:g} m on each side, given {width:.4g} m wide and "
        f"{length:.4g} m long, {unit.words}{advice}"
    )


def doubts(sides: tuple[float, float], unit: Unit) -> list[str]:
    """Return a note to the user on an unusual width and length [m] of a garment from a file.

    There is no note if the user gave the unit. Even a unit that the file states is doubted, because many programs write
    a wrong unit into the header.
    """
    longest = max(sides)
    probable = probable_scale(sides, unit)
    if unit.given or probable is None or USUAL[0] <= longest <= DOUBTFUL:
        return []
    return [
        f"{longest:.2f} m for its longer side is unusual: is the file in {NAMES[probable]}? If so, give scale = "
        f"{probable:g} under [garment] in a garment file, or --scale {probable:g}"
    ]
