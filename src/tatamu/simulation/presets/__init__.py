"""Presets: materials from the literature in files NAME.toml, for users who did not measure their cloth."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from tatamu.base.errors import InputError
from tatamu.base.files import read_toml, validated
from tatamu.base.records import Record
from tatamu.simulation.material import PRESETS, Material, preset_names

Range = Annotated[tuple[float, float], Field(description="[low, high]")]


class About(Record):
    """Title and note of a preset."""

    title: str
    note: str = ""
    """Warning about the use of the preset."""


class Preset(Record):
    """A material with the sources of its values."""

    name: str
    preset: About
    material: Material
    spread: dict[str, Range] = Field(default_factory=dict)
    """Range of values that the source states, by field of the material."""
    source: dict[str, str] = Field(default_factory=dict)
    """Source of each value, or that it is assumed, by field of the material."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for table in (self.spread, self.source):
            for name in table:
                if name not in Material.model_fields:
                    raise ValueError(f"spread and source must only contain fields of a material, given {name}")
        for name, (low, high) in self.spread.items():
            if not low <= getattr(self.material, name) <= high:
                raise ValueError(f"{name} must be within its spread, {low:g} to {high:g}")
        return self


def load_preset(name: str) -> Preset:
    """Read the preset with this name, or raise InputError."""
    path = PRESETS / f"{name}.toml"
    if not path.is_file():
        raise InputError(f"material: must be one of {', '.join(preset_names())}, given {name!r}")
    return validated(Preset, {"name": name, **read_toml(path)}, path)
