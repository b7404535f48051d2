"""The saved state of a running scene, and the functions that copy it from and to the arrays of the compiled loops."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.simulation.native.grippers import GripperState
from tatamu.simulation.native.led_bodies import BodyPose
from tatamu.simulation.native.options import Options
from tatamu.simulation.native.rest import Rest
from tatamu.simulation.native.system import System
from tatamu.simulation.scene import Scene
from tatamu.simulation.source import source_digest


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
    """Copies of the arrays that change during the simulation, in the order of `_changing`."""


def digest(scene: Scene, options: Options) -> str:
    """Return a hash of scene, options and source code, which determine a rollout."""
    text = f"{scene.model_dump_json()}{options!r}{source_digest()}"
    return hashlib.sha256(text.encode()).hexdigest()


def copy_arrays(system: System) -> tuple[np.ndarray, ...]:
    """Copy all arrays that time steps change and later steps read."""
    return tuple(array.copy() for array in _changing(system))


def set_arrays(system: System, arrays: tuple[np.ndarray, ...]) -> None:
    """Copy the arrays from `copy_arrays` back into the system."""
    for array, saved in zip(_changing(system, arrays[0]), arrays, strict=True):
        array[...] = saved


def _changing(system: System, counters: np.ndarray | None = None) -> Iterator[np.ndarray]:
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
    yield from (edges.pairs[:pairs], edges.wake[:pairs], edges.meets[:pairs], edges.guarded)
    yield edges.awake[: int(used["pairs_awake"])]
