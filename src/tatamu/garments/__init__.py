"""Garments by name."""

from __future__ import annotations

from collections.abc import Callable

from tatamu.errors import InputError
from tatamu.garments.garment import Garment
from tatamu.garments.towel import towel
from tatamu.garments.trousers import trousers
from tatamu.garments.tshirt import tshirt
from tatamu.material import Material

GARMENTS: dict[str, Callable[..., Garment]] = {"towel": towel, "tshirt": tshirt, "trousers": trousers}
"""Name of each garment and the function that makes it from size, material and spacing."""

__all__ = ["GARMENTS", "Garment", "make_garment", "towel", "trousers", "tshirt"]


def make_garment(
    name: str,
    size: tuple[float, float] | None = None,
    material: Material | None = None,
    spacing: float | None = None,
) -> Garment:
    """The garment of that name; what is not given is the garment's own default.

    Raises:
        InputError: There is no such garment, or no garment has such a size or spacing.
    """
    if name not in GARMENTS:
        raise InputError(f"garment: must be one of {', '.join(GARMENTS)}, given {name!r}")
    given = {"size": size, "material": material, "spacing": spacing}
    return GARMENTS[name](**{key: value for key, value in given.items() if value is not None})
