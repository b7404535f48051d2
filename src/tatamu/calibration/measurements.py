"""The readings of ruler, scale and board in `measurements.toml`. docs/guide/calibration.md shows each reading.

    [garment]     name, size, mass                the garment and its mass
    [TEST]        its readings                    a table for each test that was made: the modules of `registry`
    [errors]      length, mass, H_s               standard deviation of one reading

A reading is a number or a list of repeats. All numbers are in SI units, such as metres and kilograms.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, create_model, model_validator

from tatamu.base.files import read_toml, validated
from tatamu.base.records import Record
from tatamu.calibration.entry import Errors, TestEntry
from tatamu.calibration.quantity import Length, Masses
from tatamu.calibration.readings import Reading
from tatamu.calibration.registry import TESTS
from tatamu.simulation.material import THICKNESS


class GarmentReadings(Record):
    """The garment that was measured, and its mass."""

    name: str
    """Name of a garment, or the path of a garment's file, as for `tatamu learn`."""
    size: Annotated[tuple[Length, Length], BeforeValidator(lambda v: tuple(v) if isinstance(v, list) else v)] | None = (
        None
    )
    """Width and length of the garment [m]; None for the size of the garment's pattern."""
    mass: Masses
    """Mass of the whole garment [kg]."""
    material: str | None = None
    """Preset or material file for parameters that are not measured; None for the garment's own fabric."""
    thickness: Annotated[float, Field(ge=THICKNESS[0], le=THICKNESS[1])] | None = None
    """Thickness of one layer [m], see `Material.thickness`; None for the thickness of the material."""


class Head(Record):
    """The fields with which every file of measurements begins."""

    version: Literal[1] = 1
    garment: GarmentReadings


_TABLES: dict[str, Any] = {name: (test.entry | None, None) for name, test in TESTS.items()}
_WithTests: Any = create_model("_WithTests", __base__=Head, **_TABLES)
"""Measurements with a field for the table of each test. The field is None if the test was not made."""


class Measurements(_WithTests):
    """All readings of one garment. The fields of tests that were not made are None."""

    errors: Errors = Field(default_factory=Errors)

    @model_validator(mode="after")
    def _check(self) -> Self:
        made = self.entries()
        own = [name for name, test in TESTS.items() if not test.needs]
        if not set(own) & set(made):
            tables = ", ".join(f"[{name}]" for name in own)
            raise ValueError(f"must hold at least one of the tables {tables}; given none")
        for name in made:
            test = TESTS[name]
            if not set(test.needs) <= set(made):
                needed = " and ".join(f"[{other}]" for other in test.needs)
                raise ValueError(f"{name}: needs {needed} as well, as {test.needs_because}")
        return self

    def entries(self) -> dict[str, TestEntry]:
        """Return the tables of the tests that were made, by the names of the tests."""
        tables = {name: getattr(self, name) for name in TESTS}
        return {name: table for name, table in tables.items() if table is not None}

    def readings(self) -> dict[str, Reading]:
        """Return every reading, by its name."""
        errors: Errors = self.errors
        garment: GarmentReadings = self.garment
        found = {"mass": Reading.of(garment.mass, errors.mass, "kg")}
        for name, side in zip(("width", "length"), garment.size or (), strict=False):
            found[name] = Reading.of((side,), errors.length)
        for entry in self.entries().values():
            found |= entry.readings(errors)
        return found


def load_measurements(path: Path) -> Measurements:
    """Read and check a file of measurements.

    Raises:
        InputError: If the file cannot be read, a field is unknown, or a reading is impossible.
    """
    return validated(Measurements, read_toml(path), path)
