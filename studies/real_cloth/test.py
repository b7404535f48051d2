"""Defines the interface of a test on real cloth.

A test reads measurements, simulates the experiment, and makes a section with the result.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, ClassVar

from studies.real_cloth.bench import Bench
from studies.real_cloth.section import Section


class RealTest(ABC):
    """Base class of all tests on real cloth."""

    name: ClassVar[str]
    """Name of the test, which the option `--only` uses."""

    @abstractmethod
    def load(self, data: Path) -> Any:
        """Read the measurements of the test from the folder `data`.

        Raises:
            InputError: If a file is wrong or missing.
        """

    @abstractmethod
    def simulations(self, measured: Any, bench: Bench) -> int:
        """Return the approximate number of simulations that the test needs."""

    @abstractmethod
    def run(self, measured: Any, bench: Bench) -> Section:
        """Simulate the experiments of the test, and return a comparison of the predictions with the measurements."""
