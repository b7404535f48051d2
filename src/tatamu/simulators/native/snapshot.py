"""The state of a running scene, copied out of the arrays of the compiled loops and back into them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.scene import Scene
from tatamu.simulators.native.grippers import GripperState
from tatamu.simulators.native.options import Options
from tatamu.simulators.native.rest import Rest
from tatamu.simulators.native.system import System
from tatamu.simulators.source import source_digest


@dataclass(frozen=True)
class SimulationState:
    """Everything that the rest of a rollout depends on, except its scene. It can be pickled."""

    digest: str
    """Digest of the scene, the options and the source of the simulator."""
    number: int
    """Outer steps made."""
    requested: float
    """Time requested so far [s]."""
    untangle_at: int
    """Outer step at which layers are taken apart again."""
    rest: Rest
    """Whether the cloth rests."""
    grippers: GripperState
    arrays: tuple[np.ndarray, ...]
    """Copies of the arrays that steps change, in the order of `_changing`."""


def digest(scene: Scene, options: Options) -> str:
    """Return a hexadecimal hash of everything that determines a rollout: scene, options and source."""
    text = f"{scene.model_dump_json()}{options!r}{source_digest()}"
    return hashlib.sha256(text.encode()).hexdigest()


def copy_arrays(system: System) -> tuple[np.ndarray, ...]:
    """Copy everything that outer steps change and later ones read, without scratch and unused memory."""
    return tuple(array.copy() for array in _changing(system))


def set_arrays(system: System, arrays: tuple[np.ndarray, ...]) -> None:
    """Copy arrays of `copy_arrays` back."""
    for array, saved in zip(_changing(system, arrays[0]), arrays, strict=True):
        array[...] = saved


def _changing(system: System, counters: np.ndarray | None = None) -> Iterator[np.ndarray]:
    """The arrays that outer steps change and later ones read, the counters first.

    Args:
        system: The running scene.
        counters: Counters of the pairs of edges in use; None for those of the system.
    """
    state, contact = system.state, system.contact
    own = np.asarray(contact.counters)
    used: Any = own if counters is None else counters
    yield own
    yield from (state.X, state.V, state.inverse_mass, state.free, system.mesh.inverse_mass)
    yield from (state.positions.x, state.positions.predicted)  # air asks what contact moved in the step before
    yield from (state.hinges.slip.plastic, state.surface.normals, state.surface.carried, state.surface.path)
    yield from contact.vertex_face
    yield from contact.activity
    yield from contact.motion
    edges = contact.edge_edge
    pairs = int(used["pairs"])
    yield from (edges.pairs[:pairs], edges.wake[:pairs], edges.meets[:pairs], edges.guarded)
    yield edges.awake[: int(used["pairs_awake"])]
