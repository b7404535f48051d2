"""A crease that was pressed: against a strip in one dimension, and hidden friction that comes back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tatamu.calibration import Calibration, Measurements, calibrate
from tatamu.calibration.crease import ARM, PressedCrease
from tatamu.calibration.sag import Sag
from tatamu.simulation.material import Material
from tatamu.simulation.simulators import simulate
from tests.readings import of_towel

CLOTH = Material(areal_density=0.25, stretch_stiffness=300.0, bending_rigidity=4e-5, bending_hysteresis=1e-3)
GAP, BOARD = 0.01, 0.0027
FREE = 0.05
ROUND = 2.0 * GAP / np.pi
"""Distance of the ends at which the closed hinge is half a circle [m]."""


def crease(apart: float = 2.0 * BOARD + CLOTH.thickness) -> PressedCrease:
    return PressedCrease(GAP, apart, CLOTH.bending_length)


def angle(material: Material, apart: float = ROUND) -> float:
    """That stays [rad]."""
    test = crease(apart)
    return test.reading(simulate(test.scene(material))) / ARM


def measurements(**more: Any) -> Measurements:
    sag = Sag(FREE).reading(simulate(Sag(FREE).scene(CLOTH)))
    hangs = {"edge": "bottom", "free_length": FREE, "sag": sag}
    return of_towel((0.3, 0.6), CLOTH.areal_density, CLOTH.thickness, sag=hangs, **more)


def creased(degrees: float) -> Calibration:
    return calibrate(measurements(crease={"gap": GAP, "board": BOARD, "angle": degrees}))


@pytest.mark.parametrize("friction", [4e-4, 1e-3, 2e-3])
def test_a_half_circle_keeps_the_curvature_at_which_friction_holds_bending(friction: float) -> None:
    rough = CLOTH.model_copy(update={"bending_hysteresis": friction})
    assert angle(rough) == pytest.approx(friction / CLOTH.bending_rigidity * GAP, rel=0.04)


def test_without_friction_nothing_stays() -> None:
    assert abs(angle(CLOTH.model_copy(update={"bending_hysteresis": 0.0}))) < 0.01


@pytest.mark.slow
def test_hidden_friction_comes_back_and_bending_that_it_had_hidden() -> None:
    found = creased(float(np.degrees(angle(CLOTH, crease().apart))))
    for name in ("bending_hysteresis", "bending_rigidity"):
        off = abs(float(np.log(getattr(found.material, name) / getattr(CLOTH, name))))
        assert off <= 0.03 < found.relative(name) < 0.5, name
    without = calibrate(measurements())
    assert without.material.bending_rigidity > 1.5 * CLOTH.bending_rigidity
    assert "bending_hysteresis" in found.known and "bending_hysteresis" not in without.listed


@pytest.mark.slow
def test_contributions_are_what_a_changed_angle_does() -> None:
    wide = float(np.degrees(angle(CLOTH, crease().apart)))
    found, moved = creased(wide), creased(wide + 1.0)
    step = ARM * np.radians(1.0) / found.readings["angle"].uncertainty
    for name, place in (("bending_rigidity", 2), ("bending_hysteresis", -1)):
        got = float(np.log(getattr(moved.material, name) / getattr(found.material, name)))
        stated = found.contributions["angle"][place] * step
        assert got == pytest.approx(stated, abs=0.01 + 0.2 * abs(stated)), name


@pytest.mark.parametrize(("degrees", "side"), [(1.0, "at most"), (150.0, "at least")])
def test_an_angle_that_tells_nothing_bounds(degrees: float, side: str) -> None:
    found = creased(degrees)
    fit = found.bounding("bending_hysteresis")
    assert fit is not None and fit.bound == side
    (said,) = found.setup.tests["crease"].advice(found, fit)
    assert side in said
