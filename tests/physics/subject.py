"""The simulator that is tested."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Scene
from tatamu.simulation.simulators import named
from tests.physics.limits import LIMITS
from tests.physics.scenes import held


@dataclass(frozen=True)
class Subject:
    """A simulator with the limits of its errors."""

    name: str
    """Name of the simulator in `tatamu.simulation.simulators`. Other processes start it by this name."""
    simulate: Callable[[Scene], Rollout]
    simulate_many: Callable[[Sequence[Scene]], list[Rollout]]
    limits: dict[str, float] = field(default_factory=dict)
    """Largest allowed error of each quantity, by its name. A quantity without a limit is reported, but cannot fail."""

    @classmethod
    def named(cls, name: str) -> Subject:
        """Return a simulator with the limits that are stated for it.

        Raises:
            InputError: If no simulator has this name.
        """
        simulator = named(name)
        return cls(name, simulator.simulate, simulator.simulate_many, LIMITS.get(name, {}))

    def limit(self, quantity: str, factor: float = 1.0) -> float | None:
        """Return the largest allowed error of a quantity, in the unit of its row; None if the quantity has no limit.

        Args:
            quantity: Name of the quantity in `limits.py`.
            factor: Factor from the unit of `limits.py` to the unit of the row.
        """
        limit = self.limits.get(quantity)
        return None if limit is None else factor * limit

    def end(self, cloth: Cloth, material: Material, vertices: np.ndarray, duration: float) -> np.ndarray:
        """Simulate a cloth whose vertices `vertices` are held without motion.

        Returns:
            Positions at the end [m], shape (n, 3).
        """
        scene = Scene(cloth=cloth, material=material, grippers=[held(vertices)], duration=duration)
        return self.simulate(scene).positions[-1]
