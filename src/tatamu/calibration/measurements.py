"""The readings of ruler, scale and board in `measurements.toml`, and how to take them (docs/guide/calibration.md).

    [garment]     name, size, mass                the garment and its mass
    [TEST]        its readings                    a table for each test that was made, see `TESTS`
    [errors]      length, mass, H_s               standard deviation of one reading

A reading is a number or a list of repeats. All numbers are in SI units, such as metres and kilograms.
"""

from __future__ import annotations

from pathlib import Path
from string import Template
from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from tatamu.base.files import read_toml, validated
from tatamu.base.records import Record
from tatamu.calibration.bias import Bias, BiasReadings
from tatamu.calibration.crease import CreaseReadings, PressedCrease
from tatamu.calibration.elongation import Elongation, ElongationReadings
from tatamu.calibration.fading import Fading, FadingReadings
from tatamu.calibration.friction import FrictionReadings, Slope
from tatamu.calibration.loop import Loop, LoopReadings
from tatamu.calibration.plate import Plate, PlateReadings
from tatamu.calibration.push import Push, PushReadings
from tatamu.calibration.readings import Errors, Length, Masses, Reading, TestEntry
from tatamu.calibration.sag import Sag, SagReadings
from tatamu.calibration.swing import SwingReadings, TenSwings
from tatamu.calibration.test import CalibrationTest, texts
from tatamu.garments import Garment, make_garment
from tatamu.simulation.material import THICKNESS

TESTS: dict[str, type[CalibrationTest]] = {
    test.name: test for test in (Elongation, Slope, Sag, Loop, Plate, PressedCrease, Push, Bias, TenSwings, Fading)
}
"""All calibration tests by their names, in the order of the guide. A new test needs a module and a name here."""


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


class Measurements(Record):
    """All readings of one garment. The fields of tests that were not made are None."""

    version: Literal[1] = 1
    garment: GarmentReadings
    elongation: ElongationReadings | None = None
    friction: FrictionReadings | None = None
    sag: SagReadings | None = None
    loop: LoopReadings | None = None
    plate: PlateReadings | None = None
    crease: CreaseReadings | None = None
    push: PushReadings | None = None
    bias: BiasReadings | None = None
    swing: SwingReadings | None = None
    fading: FadingReadings | None = None
    errors: Errors = Field(default_factory=Errors)

    @model_validator(mode="after")
    def _check(self) -> Self:
        made = self.entries()
        own = [name for name, test in TESTS.items() if not test.needs]
        if not set(own) & set(made):
            tables = ", ".join(f"[{name}]" for name in own)
            raise ValueError(f"must contain at least one of the tables {tables}, given none")
        for name in made:
            test = TESTS[name]
            if not set(test.needs) <= set(made):
                needed = " and ".join(f"[{other}]" for other in test.needs)
                raise ValueError(
                    f"{name}: must be given together with {needed}, because {texts(name)['needs_because']}"
                )
        return self

    def entries(self) -> dict[str, TestEntry]:
        """Return the tables of the tests that were made, by the names of the tests."""
        tables = {name: getattr(self, name) for name in TESTS}
        return {name: table for name, table in tables.items() if table is not None}

    def readings(self) -> dict[str, Reading]:
        """Return every reading, by its name."""
        found = {"mass": Reading.of(self.garment.mass, self.errors.mass, "kg")}
        for name, side in zip(("width", "length"), self.garment.size or (), strict=False):
            found[name] = Reading.of((side,), self.errors.length)
        for entry in self.entries().values():
            found |= entry.readings(self.errors)
        return found


def load_measurements(path: Path) -> Measurements:
    """Read and check a file of measurements.

    Raises:
        InputError: If the file cannot be read, a field is unknown, or a reading is impossible.
    """
    return validated(Measurements, read_toml(path), path)


def instructions() -> str:
    """Return the instructions for measuring: the garment's mass and size first, then every test with its number."""
    numbers = {name: number for number, name in enumerate(TESTS, 1)}
    tests = [
        f"{number}  {Template(texts(name)['instructions']).substitute(numbers)}" for name, number in numbers.items()
    ]
    return "\n".join([texts("guide")["opening"], *tests, texts("guide")["commands"]])


def template(name: str) -> str:
    """Return the text of measurements.toml for a garment, with empty readings.

    Raises:
        InputError: If no garment has this name.
    """
    garment = make_garment(name)
    width, length = (f"{side:g}" for side in garment.size)
    preset = {"towel": "terry", "tshirt": "interlock", "trousers": "denim"}.get(name, "cotton")
    head = Template(texts("guide")["head"]).substitute(name=name, width=width, length=length, preset=preset)
    return "\n".join([head, *(table(test, garment) for test in TESTS), texts("guide")["errors"]])


def table(test: str, garment: Garment) -> str:
    """Return the part of a test in measurements.toml, with empty readings."""
    return Template(texts(test)["template"]).substitute(TESTS[test].blanks(garment))
