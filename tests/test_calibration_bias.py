"""A strip hung on the bias: a hidden shear stiffness comes back within its uncertainty."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from tatamu.calibration import Calibration, Measurements, calibrate
from tatamu.calibration.bias import Bias
from tatamu.simulation.material import GRAVITY, load_material
from tatamu.simulation.simulators import simulate

SIZE = (0.3, 0.6)
DENSITY, STRETCH, SHEAR = 0.3, 300.0, 15.0
STRIP = Bias(0.6, 0.06)
HIDDEN = load_material(Path("terry")).model_copy(
    update={"areal_density": DENSITY, "stretch_stiffness": STRETCH, "shear_stiffness": SHEAR}
)
LONGER = DENSITY * GRAVITY * SIZE[1] ** 2 / (2.0 * STRETCH)


def found(pulled: float, longer: float, error: float) -> Calibration:
    tables: dict[str, Any] = {
        "garment": {"name": "towel", "size": SIZE, "mass": DENSITY * SIZE[0] * SIZE[1]},
        "elongation": {"grasps": [{"edge": "bottom"}], "L1": SIZE[1] + longer, "L2": SIZE[1]},
        "bias": {"width": STRIP.width, "L1": STRIP.length + pulled, "L2": STRIP.length},
        "errors": {"length": error},
    }
    return calibrate(Measurements.model_validate(tables), spacing=0.04)


@pytest.fixture(scope="module")
def pulled() -> float:
    return STRIP.reading(simulate(STRIP.scene(HIDDEN)))


def test_a_strip_on_the_bias_is_longer_by_the_textbook(pulled: float) -> None:
    compliance = 2.0 * (1.0 - HIDDEN.poisson_ratio) / STRETCH + 1.0 / SHEAR
    textbook = DENSITY * GRAVITY * STRIP.length**2 / 8.0 * compliance
    assert -0.1 < pulled / textbook - 1.0 < 0.0  # its clamped end cannot narrow


def test_a_hidden_shear_stiffness_comes_back(pulled: float) -> None:
    calibration = found(pulled, LONGER, 0.0003)
    off = abs(float(np.log((calibration.material.shear_stiffness or np.inf) / SHEAR)))
    assert off <= calibration.relative("shear_stiffness") < 0.2
    assert "shear_stiffness" in calibration.known


def test_a_stretch_stiffness_that_is_only_bounded_leaves_the_shear_less_sure(pulled: float) -> None:
    told, bounded = (found(pulled, longer, 0.001) for longer in (LONGER, 0.0005))
    assert bounded.bounding("stretch_stiffness") is not None
    assert bounded.relative("shear_stiffness") > 1.2 * np.hypot(0.001, 0.001) / pulled
    assert told.relative("shear_stiffness") > np.hypot(0.001, 0.001) / pulled


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"width": 0.08, "L1": 0.49, "L2": 0.5}, "must be more than L2"),
        ({"width": 0.4, "L1": 0.61, "L2": 0.6}, "must be from 0.02 to 0.34 times L2"),
    ],
)
def test_a_strip_that_cannot_be_is_refused(table: dict[str, float], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        Measurements.model_validate(
            {
                "garment": {"name": "towel", "size": SIZE, "mass": 0.03},
                "elongation": {"grasps": [{"edge": "bottom"}], "L1": 0.402, "L2": 0.4},
                "bias": table,
            }
        )
