"""Add a simulator: here `native` on a table that has half its friction, which also counts its simulations.

python examples/10_your_own_simulator.py
"""

from __future__ import annotations

from collections.abc import Sequence

import tatamu as tt
from tatamu.simulation.simulators import capabilities


class Slippery:
    """Simulates a scene in `native`, with half the friction of the table."""

    CAPABILITIES = capabilities("native")
    calls = 0

    def require(self) -> None:
        """Refuse to run if something is not installed; nothing is needed."""

    def prepare(self) -> None:
        """Do what would delay the first simulation; nothing is needed."""

    def compilation(self) -> tuple[int, int]:
        """Return how many functions are compiled already, and how many there are."""
        return 0, 0

    def simulate(self, scene: tt.Scene) -> tt.Rollout:
        """Simulate a scene."""
        self.calls += 1
        material = scene.material.model_copy(update={"friction_table": 0.5 * scene.material.friction_table})
        return tt.simulate(scene.model_copy(update={"material": material}), "native")

    def simulate_many(self, scenes: Sequence[tt.Scene]) -> list[tt.Rollout]:
        """Simulate several scenes."""
        return [self.simulate(scene) for scene in scenes]


SLIPPERY = Slippery()
tt.register_simulator("slippery", SLIPPERY)


def main() -> float:
    """Return how much farther the cloth that should lie still slips on the slippery table [m]."""
    parameters = {"x1": 0.15, "z1": 0.2, "x2": 0.4, "z2": 0.2, "g1": 0, "g2": 0}
    slips = {}
    for simulator in ("native", "slippery"):
        found = tt.Nominal(tt.make_task("towel", size=(0.24, 0.5), spacing=0.03, simulator=simulator))(parameters)
        assert found.score is not None, found.error
        slips[simulator] = found.score.slip
        print(f"{simulator}: slip {1e3 * found.score.slip:.2f} mm")
    print(f"{SLIPPERY.calls} simulation on the slippery table")
    return slips["slippery"] - slips["native"]


if __name__ == "__main__":
    main()
