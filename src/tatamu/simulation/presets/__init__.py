"""Provides presets: materials from the literature, for users who did not measure their cloth.

Each preset is a file NAME.toml in this folder:

    [preset]
    title = "..."                      what it is, in a few words
    note = "..."                       optional: caveats of its use
    [material]                         the fields of tatamu.simulation.material.Material
    [spread]                           optional: FIELD = [low, high], the range found in the source
    [source]                           optional: FIELD = "source of the value, or that it is assumed"

`--material` accepts the name of a preset, or a file.
"""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tatamu.base.errors import InputError
from tatamu.base.files import read_toml, validated
from tatamu.simulation.material import PRESETS, Material, preset_names

Range = Annotated[tuple[float, float], Field(description="[low, high]")]


class About(BaseModel):
    """Title and note of a preset."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str
    """Description of the cloth in a few words."""
    note: str = ""
    """Warning about the use of the preset; empty if no warning is needed."""


class Preset(BaseModel):
    """A material with the sources of its values."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: str
    preset: About
    material: Material
    spread: dict[str, Range] = Field(default_factory=dict)
    """Range of values that the source states, by the name of the material's field."""
    source: dict[str, str] = Field(default_factory=dict)
    """Source of each value, by the name of the material's field."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for table in (self.spread, self.source):
            for name in table:
                if name not in Material.model_fields:
                    raise ValueError(f"{name} is no field of a material")
        for name, (low, high) in self.spread.items():
            if not low <= getattr(self.material, name) <= high:
                raise ValueError(f"{name} must lie within its spread, {low:g} to {high:g}")
        return self


def load_preset(name: str) -> Preset:
    """Read the preset with a given name.

    Raises:
        InputError: If there is no preset with this name.
    """
    path = PRESETS / f"{name}.toml"
    if not path.is_file():
        raise InputError(f"material: must be one of {', '.join(preset_names())}, given {name!r}")
    return validated(Preset, {"name": name, **read_toml(path)}, path)
