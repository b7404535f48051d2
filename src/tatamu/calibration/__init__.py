"""Calibration: find a material that behaves like a real cloth from three or more measurements with a ruler."""

from tatamu.calibration.advice import advice_on
from tatamu.calibration.calibrate import calibrate
from tatamu.calibration.measurements import Measurements, load_measurements
from tatamu.calibration.result import Calibration

__all__ = ["Calibration", "Measurements", "advice_on", "calibrate", "load_measurements"]
