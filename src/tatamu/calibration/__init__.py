"""Calibration: measurements with a ruler, three or more, give a simulator that behaves like the cloth at hand."""

from tatamu.calibration.advice import advice_on
from tatamu.calibration.calibrate import calibrate
from tatamu.calibration.measurements import Measurements, load_measurements
from tatamu.calibration.result import Calibration

__all__ = ["Calibration", "Measurements", "advice_on", "calibrate", "load_measurements"]
