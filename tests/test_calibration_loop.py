"""The loop of a fold as a reading: right by the heavy chain, and what it adds to the sag."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from tatamu import Material, simulate
from tatamu.base.errors import InputError
from tatamu.calibration import Calibration, Measurements, advice_on, calibrate
from tatamu.calibration.loop import HEIGHT, LIFT, Loop
from tatamu.calibration.match import match
from tatamu.calibration.page import page
from tatamu.calibration.parameters import LIMITS
from tatamu.calibration.sag import Sag
from tatamu.simulation.material import GRAVITY
from tests.physics.chain import FoldedStrip
from tests.readings import of_towel

DENSITY, THICKNESS = 0.2, 0.001
SIZE, FREE = (0.2, 0.4), 0.03


def cloth(bending_length: float) -> Material:
    return Material(
        areal_density=DENSITY,
        stretch_stiffness=200.0,
        bending_rigidity=DENSITY * GRAVITY * bending_length**3,
        thickness=THICKNESS,
    )


@cache
def loop_of(bending_length: float) -> float:
    """Height of the loop of a heavy chain: its top over the table [m]."""
    half = 4.2 * bending_length
    return float(FoldedStrip(2 * half, bending_length, THICKNESS, THICKNESS).solve()[:, 1].max()) + 0.5 * THICKNESS


def measured(**tables: Any) -> Measurements:
    return of_towel(SIZE, DENSITY, THICKNESS, **tables)


@pytest.mark.parametrize("bending_length", [0.012, 0.03])
def test_the_simulated_loop_is_as_high_as_the_heavy_chain(bending_length: float) -> None:
    test = Loop(loop_of(bending_length), THICKNESS)
    got = test.reading(simulate(test.scene(cloth(bending_length))))
    assert got == pytest.approx(loop_of(bending_length), rel=0.01)
    assert test.height == pytest.approx(HEIGHT * bending_length + LIFT * THICKNESS, rel=0.02)


@pytest.fixture(scope="module")
def limp() -> Calibration:
    """A cloth of which the sag tells nothing: it hangs straight down."""
    height = round(loop_of(0.012), 3)
    return calibrate(measured(loop={"height": height}, sag={"edge": "bottom", "free_length": 0.06, "sag": 0.059}))


def test_the_loop_tells_bending_where_the_sag_cannot(limp: Calibration) -> None:
    assert "bending_rigidity" in limp.known
    error = limp.material.bending_rigidity / cloth(0.012).bending_rigidity - 1.0
    assert abs(error) < 2.0 * limp.relative("bending_rigidity") < 0.7
    assert [fit.test for fit in limp.fits] == ["loop"]  # a sag that cannot tell cannot check either
    assert not any(text.startswith("sag") for text in advice_on(limp))


def test_half_a_millimetre_of_the_loop_moves_bending_as_stated(limp: Calibration) -> None:
    height = limp.readings["height"]
    more = calibrate(measured(loop={"height": height.value + 0.5 * height.uncertainty}))
    moved = np.log(more.material.bending_rigidity / limp.material.bending_rigidity)
    assert moved == pytest.approx(0.5 * limp.contributions["height"][2], rel=0.1)


def both(over_an_edge: float, in_a_fold: float) -> Calibration:
    """Of a cloth with the sag of one bending length and the loop of another [m]."""
    strip = Sag(FREE)
    sag = strip.reading(simulate(strip.scene(cloth(over_an_edge))))
    return calibrate(
        measured(loop={"height": loop_of(in_a_fold)}, sag={"edge": "bottom", "free_length": FREE, "sag": sag})
    )


def test_sag_and_loop_that_agree_tell_bending_better_than_either() -> None:
    found = both(0.02, 0.02)
    assert found.material.bending_rigidity == pytest.approx(cloth(0.02).bending_rigidity, rel=0.03)
    alone = calibrate(measured(loop={"height": loop_of(0.02)}))
    assert found.relative("bending_rigidity") < 0.95 * alone.relative("bending_rigidity")
    assert "disagreement" not in found.contributions
    assert not any("in proportion" in text for text in advice_on(found))


def test_cloth_that_does_not_bend_in_proportion_is_said_to() -> None:
    found = both(0.015, 0.03)
    told = {fit["test"]: fit["alone"] for fit in found.to_toml()["fit"]}
    assert told["sag"] == pytest.approx(cloth(0.015).bending_rigidity, rel=0.03)
    assert told["loop"] == pytest.approx(cloth(0.03).bending_rigidity, rel=0.1)
    low, high = (np.log(told[name] / found.material.bending_rigidity) for name in ("sag", "loop"))
    assert low < 0.0 < high < -low, "the loop is read better than the sag over this short length"
    assert found.relative("bending_rigidity") == pytest.approx(np.sqrt(-low * high), rel=0.05)
    assert any("does not bend in proportion" in text for text in advice_on(found))
    text = page(found)
    assert "Loop: bending rigidity B" in text and "Alone it says" in text and "which disagree" in text
    assert ">height</text>" in text and "the height of the loop" in text


def test_a_loop_that_the_simulator_cannot_follow_is_left_out_and_said(monkeypatch: pytest.MonkeyPatch) -> None:
    stiffest = 1.5 * cloth(0.015).bending_rigidity
    monkeypatch.setitem(LIMITS, "bending_rigidity", (1e-8, stiffest))
    found = both(0.015, 0.03)
    loop = found.fit("loop")
    assert loop is not None and loop.bound == "at least" and loop.alone == pytest.approx(stiffest)
    assert found.material.bending_rigidity == pytest.approx(cloth(0.015).bending_rigidity, rel=0.03)
    assert "bending_rigidity" in found.known and not found.to_toml()["bound"]
    assert sum("loop: no value of B makes native reach" in text for text in advice_on(found)) == 1
    assert f"Alone it says at least {1e6 * stiffest:.4g} µN m." in page(found)


def test_a_loop_pressed_flat_only_bounds_bending_and_lets_the_sag_tell_it() -> None:
    flat = {"height": 2.5 * THICKNESS}
    alone = calibrate(measured(loop=flat))
    assert alone.fit("loop").bound == "at most" and "bending_rigidity" not in alone.known  # type: ignore[union-attr]
    assert any("no ruler can read the loop" in text for text in advice_on(alone))
    both = calibrate(measured(loop=flat, sag={"edge": "bottom", "free_length": FREE, "sag": 0.02}))
    assert [fit.test for fit in both.fits] == ["sag"] and "bending_rigidity" in both.known
    with pytest.raises(InputError, match="must exceed the thickness of two layers"):
        calibrate(measured(loop={"height": 1.5 * THICKNESS}))


def test_a_rising_reading_is_matched_like_a_falling_one() -> None:
    found = match(lambda b: 3.0 * b**0.3, 6.0, 1.0, (1e-3, 1e3), 1e-6, np.log, rising=True)
    assert found.reached and found.parameter == pytest.approx(2.0 ** (1 / 0.3), rel=1e-4)
    assert found.reading == pytest.approx(6.0) and all(value > 0 for _, value in found.samples)
