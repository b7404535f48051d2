"""The simulator under test, as the checks see it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from tatamu.rollout import Rollout
from tatamu.scene import Scene
from tatamu.simulators import named
from tatamu.validation.limits import LIMITS


@dataclass(frozen=True)
class Subject:
    """A simulator with the limits it is held to."""

    name: str
    """Name in `tatamu.simulators`; other processes start it by this name."""
    simulate: Callable[[Scene], Rollout]
    simulate_many: Callable[[Sequence[Scene]], list[Rollout]]
    limits: dict[str, float] = field(default_factory=dict)
    """Largest allowed error of each judged quantity; what is not listed is stated only."""

    @classmethod
    def named(cls, name: str) -> Subject:
        """The simulator of that name with its own limits.

        Raises:
            InputError: There is none of that name.
        """
        simulator = named(name)
        return cls(name, simulator.simulate, simulator.simulate_many, LIMITS.get(name, {}))

    def limit(self, quantity: str) -> float | None:
        """Largest allowed error of a quantity, None when it is not judged."""
        return self.limits.get(quantity)
