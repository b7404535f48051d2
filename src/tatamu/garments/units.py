"""Units of length in files of garments: their metres, their sources, and the unit that was probably meant."""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.errors import InputError
from tatamu.garments.resolution import LARGEST_SIDE, SMALLEST_SIDE

NAMES = {1e-3: "millimetres", 1e-2: "centimetres", 0.0254: "inches", 0.1: "decimetres", 1.0: "metres"}
"""Units that people draw in, by their metres."""
USUAL = (0.15, 1.8)
"""Between these lies the longer side of most garments [m]."""
DOUBTFUL = 2.6
"""Larger than this is hardly any garment, though bed linen may be [m]."""


@dataclass(frozen=True)
class Unit:
    """The unit of a file's coordinates."""

    metres: float
    """Metres per unit."""
    name: str
    """The plural name of the unit that the file states."""
    source: str
    """Source of the unit: the kind of file, and the words in it."""
    given: bool = False
    """Whether the user gave it, so that it is not doubted."""

    @property
    def words(self) -> str:
        """Return the unit and its source, such as "read in millimetres (Inkscape SVG, width 620mm)"."""
        return f"read in {self.name} ({self.source})"

    def reading(self, size: tuple[float, float] | None) -> str:
        """Return the same with the size [m] that the user gave."""
        return f"{self.words}{'; scaled to that size' if size else ''}"

    def scaled(self, scale: float | None) -> Unit:
        """Return the unit with the user's metres per unit of the file; None for this one."""
        if scale is None:
            return self
        return Unit(scale, NAMES.get(scale, f"units of {scale:g} m"), f"scale {scale:g}", given=True)


def probable_scale(longest: float) -> float | None:
    """Return metres per unit with which a garment has a usual size; None if no usual unit does.

    Args:
        longest: Its longer side in units of the file.
    """
    fitting = [scale for scale in NAMES if USUAL[0] <= scale * longest <= USUAL[1]]
    return min(fitting, key=lambda scale: abs(scale * longest - 0.7), default=None)


def how_to_scale(longest: float, otherwise: float) -> str:
    """Return advice on where to give the scale, with the probable one; `otherwise` if none is known."""
    scale = probable_scale(longest) or otherwise
    return (
        f"give scale = {scale:g} under [garment] in a garment file, or --scale {scale:g}: "
        "metres per unit of the file (0.001 for millimetres); or size, in metres"
    )


def check_size_of_file(sides: tuple[float, float], what: str, unit: Unit) -> None:
    """Refuse a width and length [m] that are probably of a wrong unit.

    Raises:
        InputError: No garment is so large or so small.
    """
    if not (SMALLEST_SIDE <= min(sides) and max(sides) <= LARGEST_SIDE):
        width, length = sides
        raise InputError(
            f"{what}: is {width:.4g} m wide and {length:.4g} m long, {unit.words}, but must be from "
            f"{SMALLEST_SIDE:g} to {LARGEST_SIDE:g} m; {how_to_scale(max(sides) / unit.metres, 1e-3)}"
        )


def doubts(sides: tuple[float, float], unit: Unit) -> list[str]:
    """The note on a width and length [m] that are unusual in a unit that the user did not give.

    The unit that a file states is doubted as well, because many programs write a wrong unit into the header.
    """
    longest = max(sides)
    probable = probable_scale(longest / unit.metres)
    if unit.given or probable in (None, unit.metres) or USUAL[0] <= longest <= DOUBTFUL:
        return []
    advice = how_to_scale(longest / unit.metres, 1e-3)
    return [f"{longest:.2f} m for its longer side is unusual: is the file in {NAMES[probable]}? {advice}"]
