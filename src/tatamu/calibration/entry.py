"""The common parts of the tables in a measurements file."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated

from pydantic import Field

from tatamu.base.records import Record
from tatamu.calibration.quantity import Error
from tatamu.calibration.readings import Reading


class Errors(Record):
    """Standard deviations of single readings, one for each kind of reading.

    Each standard deviation includes all causes of error: the marks of the ruler, the eye, and the motion of the cloth.
    """

    length: Error = 0.001
    """Standard deviation of every length except H_s, the height of the board's lifted end in the friction test [m]."""
    mass: Error = 0.001
    """Standard deviation of the mass [kg]."""
    H_s: Error = 0.005
    """Standard deviation of H_s, the height of the board's lifted end in the friction test [m]."""
    time: Annotated[float, Field(ge=1e-3, le=10.0)] = 0.3
    """Standard deviation of the time of ten swings, by a stopwatch [s]."""
    swings: Annotated[float, Field(ge=1e-2, le=10.0)] = 0.3
    """Standard deviation of the number of swings until they fade [-]."""
    drape: Error = 0.03
    """Standard deviation of a drape coefficient [-]. It is large, because cloth folds differently each time."""
    angle: Annotated[float, Field(ge=0.1, le=45.0)] = 4.0
    """Standard deviation of the angle that remains in a crease [degrees]."""


class TestEntry(Record):
    """The table of one test in a measurements file: its readings, and how the cloth was held.

    Impossible readings are refused.
    """

    @abstractmethod
    def readings(self, errors: Errors) -> dict[str, Reading]:
        """Return the readings by their names. No other test uses the same names."""
