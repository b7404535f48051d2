"""Makes garments: built-in garments by their name, and the user's garments from a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.garments.garment import Garment, GarmentSource
from tatamu.garments.garmentfile import SUFFIXES, load_garment
from tatamu.garments.towel import towel
from tatamu.garments.trousers import trousers
from tatamu.garments.tshirt import tshirt
from tatamu.simulation.material import Material, load_material, measured_size

GARMENTS: dict[str, Callable[..., Garment]] = {"towel": towel, "tshirt": tshirt, "trousers": trousers}
"""Function that makes each built-in garment, by name."""

DESCRIPTIONS = {
    "towel": "one rectangular panel",
    "tshirt": "a child's, front and back",
    "trousers": "a child's, front and back",
}

__all__ = [
    "DESCRIPTIONS",
    "GARMENTS",
    "Garment",
    "GarmentSource",
    "load_garment",
    "make_garment",
    "register_garment",
    "towel",
    "trousers",
    "tshirt",
]


def register_garment(name: str, make: Callable[..., Garment], description: str = "") -> None:
    """Register a garment, so `make_garment` with this name returns it.

    Args:
        name: Name of the garment.
        make: Function that makes the garment from the keywords `size`, `material` and `spacing`, which have defaults.
        description: Description of the garment in a few words.

    Raises:
        InputError: If a garment with this name exists already.
    """
    if name in GARMENTS:
        raise InputError(f"name: must be new, given {name!r}, which is already a garment")
    GARMENTS[name] = make
    DESCRIPTIONS[name] = description


def make_garment(
    name: str,
    size: tuple[float, float] | None = None,
    material: Material | Path | str | None = None,
    spacing: float | None = None,
    scale: float | None = None,
) -> Garment:
    """Return a built-in garment by its name, or a garment from a file; None stands for the garment's default.

    Args:
        name: A name of `GARMENTS`, or the path of a garment file, an outline or a mesh (docs/guide/garments.md).
        size: Width (y) and length (x) [m]; by default as measured, if `material` is a file calibrated with this
            garment.
        material: Material of the cloth, or the name of a preset, or the path of a material file.
        spacing: Edge length of the mesh [m].
        scale: Length of one unit of the garment's file [m].

    Raises:
        InputError: If the name, the file or another argument is wrong.
    """
    file = None if isinstance(material, Material | None) else Path(material)
    fabric = material if isinstance(material, Material | None) else load_material(Path(material))
    if size is None and file is not None:
        size = measured_size(file, name)
    if fabric is not None and not fabric.bending_rigidity > 0.0:
        raise InputError(
            "material.bending_rigidity: must be above 0, given 0; without bending rigidity, a fold has no radius"
        )
    if name in GARMENTS:
        if scale is not None:
            raise InputError(
                f"scale: must be left out for the built-in garment {name}, given {scale:g}; give --size instead"
            )
        given = {"size": size, "material": fabric, "spacing": spacing}
        made = GARMENTS[name](**{key: value for key, value in given.items() if value is not None})
    elif Path(name).suffix.lower() in SUFFIXES:
        made = load_garment(Path(name), size, fabric, spacing, scale)
    else:
        raise InputError(
            f"garment: must be one of {', '.join(GARMENTS)} or a file ({', '.join(SUFFIXES)}), given {name!r}"
        )
    return replace(made, source=GarmentSource(name, size, spacing, scale, str(material) if file else None))
