"""What every registered calibration test states."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Set
from typing import Any

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.base.files import validated
from tatamu.calibration import Measurements
from tatamu.calibration.advice import NAMES
from tatamu.calibration.estimate import Estimate
from tatamu.calibration.measurements import TESTS, instructions, table
from tatamu.calibration.parameters import LIMITS, PARAMETERS
from tatamu.calibration.readings import Errors, Reading
from tatamu.calibration.setup import setup_of
from tatamu.calibration.test import ElasticTest, LaterTest, texts
from tatamu.garments import make_garment

GARMENT = {"name": "towel", "size": [0.3, 0.6], "mass": 0.04}
MEASURED: dict[str, dict[str, Any]] = {
    "elongation": {"grasps": [{"edge": "bottom"}], "L1": 0.605, "L2": 0.6},
    "friction": {"L_t": 1.0, "H_s": 0.5},
    "sag": {"edge": "bottom", "free_length": 0.05, "sag": 0.03},
    "loop": {"height": 0.025},
    "plate": {"disc": 0.3, "plate": 0.18, "drape_coefficient": 0.6, "nodes": [7]},
    "crease": {"gap": 0.01, "board": 0.003, "angle": [25.0, 28.0]},
    "swing": {"edge": "bottom", "aside": 0.1, "ten_swings": 13.0},
    "fading": {"edge": "bottom", "aside": 0.1, "to": 0.025, "count": [3.0]},
    "bias": {"width": 0.08, "L1": 0.61, "L2": 0.6},
    "push": {"length": 0.6, "pushed": 0.05, "moved": 0.02},
}
"""A reading of each test; a new test adds its own."""


IMPOSSIBLE: list[tuple[str, dict[str, Any], str]] = [
    ("friction", {"L_t": 0.6, "H_s": 100000000000000000000}, "at most 10"),
    ("sag", {"free_length": 34, "sag": 0.02}, "write 0.034; if the reading is in centimetres, write 0.34"),
    ("loop", {"height": 2.5}, "that the height is in metres"),
    ("plate", {"drape_coefficient": 47.0}, "write 0.47"),
    ("plate", {"drape_coefficient": 10**400}, "must be between 0 and 1, given 1000"),
    ("plate", {"disc": 0.15}, "1.3 to 2.5 times as wide as plate"),
    ("plate", {"nodes": [-1]}, "greater than or equal to 0"),
    ("crease", {"angle": 200.0}, "must be at most 180 degrees"),
    ("crease", {"angle": -3.0}, "at least 0"),
    (
        "crease",
        {"gap": 0.005},
        "gap must be from .* to 0.1 m, given 0.005 m; the minimum is 3 times the thickness of a board",
    ),
    ("swing", {"ten_swings": 1.2}, "3 to 40 s"),
    ("fading", {"to": 0.09}, "at most 0.8 times `aside`"),
    ("fading", {"count": [3, 101]}, "must be at most 100 swings, given 101"),
    ("bias", {"L1": 0.49, "L2": 0.5}, "must be between 1 and 1.5 times L2"),
    ("bias", {"width": 0.4}, "must be 0.02 to 0.34 times L2 .*; cut a narrower strip"),
    ("push", {"moved": 0.06}, "at most `pushed`"),
    ("push", {"length": 0.1, "moved": 0.0}, "at most 0.3"),
    ("push", {"pushed": 0.0, "moved": 0.0}, "above 0"),
    ("push", {"moved": []}, "at least one reading"),
    ("push", {"moved": -0.01}, "at least 0"),
    ("push", {"moved": False}, "finite number"),
    ("errors", {"length": 1e-300}, "greater than or equal to 0.000001"),
]
"""Test, readings that cannot be, and what is said of them."""


def made(**changed: Any) -> Measurements:
    """Return the readings, some tables changed; None leaves one out."""
    tables = {name: table for name, table in {**MEASURED, **changed}.items() if table is not None}
    return validated(Measurements, {"garment": GARMENT, **tables}, "readings.toml")


@pytest.mark.parametrize(("name", "fields", "said"), IMPOSSIBLE)
def test_impossible_readings_are_refused(name: str, fields: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        made(**{name: MEASURED.get(name, {}) | fields})


@pytest.mark.parametrize(
    ("left_out", "said"),
    [
        ({"elongation"}, r"push: .*\[elongation\] and \[friction\]"),
        ({"swing"}, r"fading: must be given together with \[swing\]"),
        (MEASURED.keys() - {"fading"}, "given none"),
    ],
)
def test_a_test_that_needs_others_is_refused_without_them(left_out: Set[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        made(**dict.fromkeys(left_out))


@pytest.mark.parametrize("name", TESTS)
def test_a_test_has_words_for_each_of_its_readings_and_no_other(name: str) -> None:
    test, entry, words = TESTS[name], made().entries()[name], texts(name)["words"]
    assert set(entry.readings(Errors())) == set(words) <= set(NAMES)
    assert all(texts(name)[key] for key in ("title", "read", "instructions", "template"))
    assert bool(test.needs) == ("needs_because" in texts(name)) and bool(test.asks) == ("without" in texts(name))
    assert bool(test.yields_to) == ("yields_because" in texts(name))
    if issubclass(test, ElasticTest):
        assert set(test.reads) <= set(words)
        assert test.size is None or test.size in made().readings()


@pytest.mark.parametrize("name", TESTS)
def test_a_test_tells_a_parameter_that_calibration_knows(name: str) -> None:
    test = TESTS[name]
    assert test.name == name and test.parameter in PARAMETERS
    assert test.parameter in LIMITS or test.samples == "speed"
    assert issubclass(test, ElasticTest) != issubclass(test, LaterTest)
    assert set(test.needs) <= set(list(TESTS)[: list(TESTS).index(name)]), "a test comes after those it needs"


@pytest.mark.parametrize("name", TESTS)
def test_the_template_of_a_test_is_its_table(name: str) -> None:
    text = re.sub(r"^# (\[|\w+ = )", r"\1", table(name, make_garment("towel")), flags=re.MULTILINE)
    assert list(tomllib.loads(text)) == [name]
    assert set(tomllib.loads(text)[name]) == set(TESTS[name].entry.model_fields)


@pytest.mark.parametrize("name", TESTS)
@pytest.mark.parametrize("bound", ["at least", "at most", None])
def test_a_test_advises_on_a_bound_and_on_a_poor_reading(name: str, bound: str | None) -> None:
    readings, setup = made().readings(), setup_of(made())
    material = setup.base.model_copy(update={"shear_stiffness": 40.0, "bending_hysteresis": 1e-3})
    test = setup.tests[name]
    fit = test.fit(Reading(0.02, 0.001), 0.021, bound, ((0.5, 0.02),))
    poor = {"mass": np.full(len(PARAMETERS), 0.8)}
    for thin in (material, material.model_copy(update={"bending_rigidity": 1e-8})):
        advice = test.advice(Estimate(thin, "native", (fit,), poor, readings, (), {}), fit)
        assert all(text.startswith(f"{name}: ") and "{" not in text for text in advice)
        assert len(advice) == (bound is not None or name in ("elongation", "sag", "bias"))


def test_the_guide_numbers_the_tests_and_names_their_tables() -> None:
    text = instructions()
    for number, name in enumerate(TESTS, 1):
        (line,) = [line for line in text.splitlines() if line.startswith(f"{number}  ")]
        assert f"[{name}]" in line
    assert "$" not in text


def test_the_simulated_copy_of_each_test_has_a_scene() -> None:
    setup = setup_of(made())
    assert list(setup.tests) == list(TESTS)
    assert all(len(test.scene(setup.base).cloth.faces) for test in setup.tests.values())


def test_no_reading_has_the_name_of_another() -> None:
    entries = made().entries().values()
    assert len(made().readings()) == 3 + sum(len(entry.readings(Errors())) for entry in entries)
