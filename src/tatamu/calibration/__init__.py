"""Calibration: three or more measurements with a ruler give a material that behaves like the measured cloth."""

from tatamu.calibration.advice import advice_on
from tatamu.calibration.calibrate import calibrate
from tatamu.calibration.measurements import Measurements, load_measurements
from tatamu.calibration.result import Calibration

__all__ = ["Calibration", "Measurements", "advice_on", "calibrate", "load_measurements"]
