"""Garments by name or from a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tatamu.errors import InputError
from tatamu.garments.garment import Garment
from tatamu.garments.garmentfile import SUFFIXES, load_garment
from tatamu.garments.towel import towel
from tatamu.garments.trousers import trousers
from tatamu.garments.tshirt import tshirt
from tatamu.material import Material

GARMENTS: dict[str, Callable[..., Garment]] = {"towel": towel, "tshirt": tshirt, "trousers": trousers}
"""Name of each garment and the function that makes it from size, material and spacing."""

DESCRIPTIONS = {
    "towel": "one rectangular panel",
    "tshirt": "a child's, front and back",
    "trousers": "a child's, front and back",
}
"""Each of them in a few words."""

__all__ = ["DESCRIPTIONS", "GARMENTS", "Garment", "load_garment", "make_garment", "towel", "trousers", "tshirt"]


def make_garment(
    name: str,
    size: tuple[float, float] | None = None,
    material: Material | None = None,
    spacing: float | None = None,
    scale: float | None = None,
) -> Garment:
    """The garment of that name or file; what is not given is the garment's own default.

    Args:
        name: A name of `GARMENTS`, or the path of a garment file, an outline or a mesh (docs/guide/garments.md).
        size: Width (y) and length (x) [m].
        material: What it is made of.
        spacing: Edge length of its mesh [m].
        scale: Metres per unit of a file.

    Raises:
        InputError: There is no such garment, or no garment has such a size, material or spacing, or the file is wrong.
    """
    if material is not None and not material.bending_rigidity > 0.0:
        raise InputError("material: bending_rigidity must be above zero, else a fold has no size, given 0")
    if name not in GARMENTS:
        if Path(name).suffix.lower() in SUFFIXES:
            return load_garment(Path(name), size, material, spacing, scale)
        raise InputError(
            f"garment: must be one of {', '.join(GARMENTS)} or a file ({', '.join(SUFFIXES)}), given {name!r}"
        )
    if scale is not None:
        raise InputError(f"scale: belongs to a file of a garment, given {scale:g} for {name}; --size stretches it")
    given = {"size": size, "material": material, "spacing": spacing}
    return GARMENTS[name](**{key: value for key, value in given.items() if value is not None})
