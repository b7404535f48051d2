"""The guide to measuring with a ruler, a scale and a board, and the file for the readings."""

from __future__ import annotations

from pathlib import Path
from string import Template
from typing import Any

from tatamu.base.files import read_toml
from tatamu.calibration.registry import TESTS
from tatamu.garments import Garment, make_garment

PRESET = {"towel": "terry", "tshirt": "interlock", "trousers": "denim"}


def instructions() -> str:
    """Return the instructions for measuring: the garment's mass and size first, then every test with its number."""
    numbers = {name: number for number, name in enumerate(TESTS, 1)}
    tests = [
        f"{number}  {Template(_texts(name)['instructions']).substitute(numbers)}" for name, number in numbers.items()
    ]
    return "\n".join([_texts("guide")["opening"], *tests, _texts("guide")["commands"]])


def template(name: str) -> str:
    """Return the text of measurements.toml for a garment, with empty readings.

    Raises:
        InputError: If no garment has this name.
    """
    garment = make_garment(name)
    width, length = (f"{side:g}" for side in garment.size)
    preset = PRESET.get(name, "cotton")
    head = Template(_texts("guide")["head"]).substitute(name=name, width=width, length=length, preset=preset)
    return "\n".join([head, *(table(test, garment) for test in TESTS), _texts("guide")["errors"]])


def table(test: str, garment: Garment) -> str:
    """Return the part of a test in measurements.toml, with empty readings."""
    return Template(_texts(test)["template"]).substitute(TESTS[test].blanks(garment))


def _texts(name: str) -> dict[str, Any]:
    return read_toml(Path(__file__).parent / "texts" / f"{name}.toml")
