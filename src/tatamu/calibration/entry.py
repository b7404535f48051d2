"""The tables of a measurements file: what they have in common."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated

from pydantic import Field

from tatamu.calibration.quantity import Error
from tatamu.calibration.readings import Reading
from tatamu.records import Record


class Errors(Record):
    """Standard deviation of one reading, all causes together: the ruler's marks, the eye, the cloth's unrest."""

    length: Error = 0.001
    """Standard deviation of every length except H_s [m]."""
    mass: Error = 0.001
    """[kg]"""
    H_s: Error = 0.005
    """[m]"""
    time: Annotated[float, Field(ge=1e-3, le=10.0)] = 0.3
    """Standard deviation of ten swings by a stopwatch [s]."""
    swings: Annotated[float, Field(ge=1e-2, le=10.0)] = 0.3
    """Standard deviation of the number of swings until they fade [-]."""
    drape: Error = 0.03
    """Standard deviation of a drape coefficient [-]: folds fall differently each time."""
    angle: Annotated[float, Field(ge=0.1, le=45.0)] = 4.0
    """Standard deviation of the angle that stays in a crease [degrees]."""


class TestEntry(Record):
    """The table of one test: its readings, and how the cloth was held. Impossible readings are refused."""

    @abstractmethod
    def readings(self, errors: Errors) -> dict[str, Reading]:
        """The readings by their names, which no other test uses."""
