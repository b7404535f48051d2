"""Cloth hung by a corner: a hidden shear stiffness comes back within its uncertainty."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from tatamu.calibration import Measurements, calibrate
from tatamu.calibration.bias import PINCH, Bias
from tatamu.calibration.elongation import Elongation, Grasp
from tatamu.garments import make_garment
from tatamu.simulators import simulate

SIZE = (0.3, 0.4)
SPACING = 0.04
SHEAR = 15.0
WHOLE = {"grasps": [{"edge": "bottom"}]}


def test_a_hidden_shear_stiffness_comes_back() -> None:
    garment = make_garment("towel", size=SIZE, spacing=SPACING)
    hidden = garment.material.model_copy(
        update={"areal_density": 0.3, "stretch_stiffness": 300.0, "shear_stiffness": SHEAR}
    )
    whole = Elongation(garment, (Grasp(edge="bottom"),))
    corner = Bias(Elongation(garment, (Grasp(edge="bottom", at=0.0, width=PINCH),)))
    longer, pulled = (test.reading(simulate(test.scene(hidden))) for test in (whole, corner))
    found = calibrate(
        Measurements.model_validate(
            {
                "garment": {"name": "towel", "size": SIZE, "mass": 0.3 * SIZE[0] * SIZE[1]},
                "elongation": {**WHOLE, "L1": whole.length + longer, "L2": whole.length},
                "bias": {"edge": "bottom", "L1": corner.hung.length + pulled, "L2": corner.hung.length},
                "errors": {"length": 0.0005},
            }
        ),
        spacing=SPACING,
    )
    off = abs(float(np.log((found.material.shear_stiffness or np.inf) / SHEAR)))
    assert off <= found.relative("shear_stiffness") < 1.0
    assert "shear_stiffness" in found.known


def test_a_corner_that_hangs_shorter_than_it_lies_is_refused() -> None:
    with pytest.raises(ValidationError, match="must be above L2"):
        Measurements.model_validate(
            {
                "garment": {"name": "towel", "size": SIZE, "mass": 0.03},
                "elongation": {**WHOLE, "L1": 0.402, "L2": 0.4},
                "bias": {"edge": "bottom", "L1": 0.49, "L2": 0.5},
            }
        )
