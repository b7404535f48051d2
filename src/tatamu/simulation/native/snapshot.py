"""The saved state of a running scene, and the arrays of the compiled loops that belong to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.simulation.native.grippers import GripperState
from tatamu.simulation.native.led_bodies import BodyPose
from tatamu.simulation.native.system import System


@dataclass(frozen=True)
class Rest:
    """State of the test whether released cloth is at rest, by displacements: its kinetic energy only shows jitter."""

    look_at: int = -1
    """Outer step of the next test; -1 while a hand holds or will hold the cloth, and when the cloth is at rest."""
    before: np.ndarray | None = None
    """Positions at the previous test [m], shape (n, 3)."""
    reached: bool = False

    def looked(self, number: int, x: np.ndarray, wait: int, still: float) -> Rest:
        """Return the state after a test in outer step `number`, with the next one after `wait` outer steps.

        Cloth is at rest if its mean displacement since the previous test is below `still` [m].
        """
        if self.before is not None and np.linalg.norm(x - self.before, axis=1).mean() < still:
            return Rest(reached=True)
        return Rest(number + wait, x.copy())


@dataclass(frozen=True)
class SimulationState:
    """Everything on which the rest of a rollout depends, except its scene; it can be pickled."""

    digest: str
    """Digest of the scene, the options and the source of the simulator."""
    number: int
    """Number of simulated outer steps."""
    requested: float
    """Total time that calls of `Simulation.advance` have requested [s]."""
    untangle_at: int
    """Outer step of the next attempt to separate crossed layers; -1 if none is planned."""
    rest: Rest
    grippers: GripperState
    bodies: dict[int, BodyPose]
    """Last target pose of each body that follows a controller."""
    arrays: tuple[np.ndarray, ...]
    """Copies of the arrays that change during the simulation, in the order of `changing`."""


def changing(system: System, counters: np.ndarray | None = None) -> Iterator[np.ndarray]:
    """Yield the arrays that time steps change and later steps read, the counters first.

    The number of edge pairs in use comes from `counters`, or from the system's own counters if None.
    """
    state, contact = system.state, system.contact
    own = np.asarray(contact.counters)
    used: Any = own if counters is None else counters
    yield own
    yield from (state.X, state.V, state.inverse_mass, state.free, system.mesh.inverse_mass)
    yield from (state.positions.x, state.positions.predicted)  # air uses them to see what contact moved before
    yield from (state.hinges.slip.plastic, state.surface.normals, state.surface.carried, state.surface.path)
    yield from contact.vertex_face
    yield from contact.activity
    yield from contact.motion
    edges = contact.edge_edge
    pairs = int(used["pairs"])
    yield from (edges.pairs[:pairs], edges.wake[:pairs], edges.meets[:pairs], edges.apart[:pairs], edges.guarded)
    yield edges.awake[: int(used["pairs_awake"])]
