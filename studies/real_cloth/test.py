"""A test on real cloth: the file it reads, and the section it makes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, ClassVar

from studies.real_cloth.bench import Bench
from studies.real_cloth.section import Section


class RealTest(ABC):
    """Base of all tests on real cloth."""

    name: ClassVar[str]
    """Name that `--only` takes."""

    @abstractmethod
    def load(self, data: Path) -> Any:
        """Read the measurements.

        Raises:
            InputError: If a file is missing in the folder, or is wrong.
        """

    @abstractmethod
    def simulations(self, measured: Any, bench: Bench) -> int:
        """Return the approximate number of simulations."""

    @abstractmethod
    def run(self, measured: Any, bench: Bench) -> Section:
        """Simulate, compare, and return the section."""
