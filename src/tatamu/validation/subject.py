"""The simulator under test."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from tatamu.material import Material
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Scene
from tatamu.simulators import named
from tatamu.validation.limits import LIMITS
from tatamu.validation.scenes import held


@dataclass(frozen=True)
class Subject:
    """A simulator with its limits."""

    name: str
    """Name in `tatamu.simulators`, by which other processes start it."""
    simulate: Callable[[Scene], Rollout]
    simulate_many: Callable[[Sequence[Scene]], list[Rollout]]
    limits: dict[str, float] = field(default_factory=dict)
    """Largest allowed error of each judged quantity; a quantity without a limit is stated, not judged."""

    @classmethod
    def named(cls, name: str) -> Subject:
        """Return a simulator with its own limits.

        Raises:
            InputError: If no simulator has that name.
        """
        simulator = named(name)
        return cls(name, simulator.simulate, simulator.simulate_many, LIMITS.get(name, {}))

    def limit(self, quantity: str, factor: float = 1.0) -> float | None:
        """Return the largest allowed error of a quantity in another unit; None if it is not judged.

        Args:
            quantity: Name of the quantity in `limits.py`.
            factor: Factor from the unit of `limits.py` to the unit of the row.
        """
        limit = self.limits.get(quantity)
        return None if limit is None else factor * limit

    def end(self, cloth: Cloth, material: Material, vertices: np.ndarray, duration: float) -> np.ndarray:
        """Simulate a cloth that a hand holds still at some vertices.

        Returns:
            Positions at the end [m], shape (n, 3).
        """
        scene = Scene(cloth=cloth, material=material, grippers=[held(vertices)], duration=duration)
        return self.simulate(scene).positions[-1]
