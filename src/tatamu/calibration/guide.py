"""The guide to measuring with a ruler, a scale and a board, and the file for the readings."""

from __future__ import annotations

from string import Template

from tatamu.calibration.registry import TESTS
from tatamu.garments import make_garment

PRESET = {"towel": "terry", "tshirt": "interlock", "trousers": "denim"}

OPENING = """\
Three measurements of your garment are enough to simulate its cloth. The others are for limp cloth, for drape and for
fast hands. You need a ruler with millimetres, a kitchen scale, and two more rulers or flat strips as a grip. You also
need a board that is longer than the garment and has the surface on which the garment will be folded. Let the cloth lie
for a minute before each measurement. Repeat what you can, and write the readings as a list: [0.804, 0.805].

0  Weigh and size the garment.                                                            [garment] mass, size
   mass: in kilograms. size: width and length of the garment when it lies flat, in metres.
"""

COMMANDS = """\
    tatamu measure --template towel            writes measurements.toml, to be filled in
    tatamu calibrate measurements.toml --out my-towel.toml
    tatamu learn towel --material my-towel.toml --out runs/my-towel
"""


def instructions() -> str:
    """Return the instructions for measuring: the garment's mass and size first, then every test with its number."""
    numbers = {name: number for number, name in enumerate(TESTS, 1)}
    tests = [f"{numbers[name]}  {Template(test.instructions).substitute(numbers)}" for name, test in TESTS.items()]
    return "\n".join([OPENING, *tests, COMMANDS])


def template(name: str) -> str:
    """Return the text of measurements.toml for a garment, with empty readings.

    Raises:
        InputError: If no garment has this name.
    """
    garment = make_garment(name)
    head = f"""\
# Readings of one {name}. Metres and kilograms; a reading may be repeated: [0.804, 0.805].
# `tatamu measure` says how to read each. Leave out a whole table [..] if that test was not made.

[garment]
name = "{name}"
size = [{garment.size[0]:g}, {garment.size[1]:g}]    # width, length
mass = []
# material = "{PRESET.get(name, "cotton")}"    # optional: preset or file for what is not measured (`tatamu materials`)
# thickness = 0.001      # optional: of one layer
"""
    errors = """\
[errors]                 # standard deviation of one reading, all causes together
length = 0.001
mass = 0.001
H_s = 0.005
"""
    return "\n".join([head, *(test.template(garment) for test in TESTS.values()), errors])
