"""The tables of a measurements file: what they have in common."""

from __future__ import annotations

from abc import abstractmethod

from pydantic import BaseModel, ConfigDict

from tatamu.calibration.quantity import Error
from tatamu.calibration.readings import Reading


class Part(BaseModel):
    """A table of the file: frozen, every key known, every number finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Errors(Part):
    """Standard deviation of one reading, all causes together: the ruler's marks, the eye, the cloth's unrest."""

    length: Error = 0.001
    """Of every length but H_s [m]."""
    mass: Error = 0.001
    """[kg]"""
    H_s: Error = 0.005
    """[m]"""


class TestEntry(Part):
    """The table of one test: its readings, and how the cloth was held. Impossible readings are refused."""

    @abstractmethod
    def readings(self, errors: Errors) -> dict[str, Reading]:
        """The readings by their names, which no other test uses."""
