"""All calibration tests, in the order of the guide. A new test needs a module, and a name in this list."""

from __future__ import annotations

from tatamu.calibration.bias import Bias
from tatamu.calibration.crease import PressedCrease
from tatamu.calibration.elongation import Elongation
from tatamu.calibration.fading import Fading
from tatamu.calibration.friction import Slope
from tatamu.calibration.loop import Loop
from tatamu.calibration.plate import Plate
from tatamu.calibration.push import Push
from tatamu.calibration.sag import Sag
from tatamu.calibration.swing import TenSwings
from tatamu.calibration.test import CalibrationTest

TESTS: dict[str, type[CalibrationTest]] = {
    test.name: test for test in (Elongation, Slope, Sag, Loop, Plate, PressedCrease, Push, Bias, TenSwings, Fading)
}
"""Calibration tests by their names."""
