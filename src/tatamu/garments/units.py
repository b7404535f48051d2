"""Handles the unit of length of a garment file.

For each file, tatamu records the length of the unit in metres, and the source of the unit, for example a word in the
file. A wrong unit usually gives the garment an unusual size. If the size is unusual, tatamu warns the user. If no
garment has such a size, tatamu refuses the file.
"""

from __future__ import annotations

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


def probable_scale(longest: float) -> float | None:
    """Return the length [m] of a unit with which the garment has a usual size; None if no unit gives a usual size.

    Args:
        longest: Longer side of the garment in units of the file.
    """
    fitting = [scale for scale in NAMES if USUAL[0] <= scale * longest <= USUAL[1]]
    return min(fitting, key=lambda scale: abs(scale * longest - 0.7), default=None)


def how_to_scale(longest: float, otherwise: float) -> str:
    """Return advice to the user on how to give the length of a file's unit, with the probable length as an example.

    If no length is probable, the example is `otherwise`.
    """
    scale = probable_scale(longest) or otherwise
    return (
        f"give scale = {scale:g} under [garment] in a garment file, or --scale {scale:g}: "
        "metres per unit of the file (0.001 for millimetres); or size, in metres"
    )


def check_size_of_file(sides: tuple[float, float], what: str, unit: Unit) -> None:
    """Refuse a width and length [m] that probably result from a wrong unit.

    Raises:
        InputError: If no garment is this large or this small.
    """
    if not (SMALLEST_SIDE <= min(sides) and max(sides) <= LARGEST_SIDE):
        width, length = sides
        raise InputError(
            f"{what}: is {width:.4g} m wide and {length:.4g} m long, {unit.words}, but must be from "
            f"{SMALLEST_SIDE:g} to {LARGEST_SIDE:g} m; {how_to_scale(max(sides) / unit.metres, 1e-3)}"
        )


def doubts(sides: tuple[float, float], unit: Unit) -> list[str]:
    """Return a note to the user on an unusual width and length [m] of a garment from a file.

    There is no note if the user gave the unit. Even a unit that the file states is doubted, because many programs write
    a wrong unit into the header.
    """
    longest = max(sides)
    probable = probable_scale(longest / unit.metres)
    if unit.given or probable in (None, unit.metres) or USUAL[0] <= longest <= DOUBTFUL:
        return []
    advice = how_to_scale(longest / unit.metres, 1e-3)
    return [f"{longest:.2f} m for its longer side is unusual: is the file in {NAMES[probable]}? {advice}"]
