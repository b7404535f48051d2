"""Compilation of functions (kernels) in two processes at the same time, if no compiled kernels are on disk.

The compiler has a lock, so threads would wait for each other. Therefore a second process compiles the functions of the
time steps and writes them to disk. Meanwhile this process compiles the search for contact candidates. Then it waits for
the second process. At last it compiles the outermost loop, and everything that the second process did not finish.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numba import typeof

from tatamu.simulation.material import Material
from tatamu.simulation.native import air
from tatamu.simulation.native.contact import edge_edge, impact_zones, table, vertex_face
from tatamu.simulation.native.contact.bodies import sweep as rigid
from tatamu.simulation.native.elastic import bending, membrane
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.native.step import advance
from tatamu.simulation.native.system import System
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tatamu.simulation.side_by_side import processors

LONGEST = 300.0
"""Longest time to wait for the second process [s]."""
COMMAND = f"from {__name__} import compile_but_search; compile_but_search()"


def smallest_scene() -> Scene:
    """Return a short scene of two triangles. Functions that are compiled for it can be used for every scene."""
    corners = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]]
    material = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5)
    hand = Gripper(vertices=[0], times=[0.0], displacements=np.zeros((1, 3)), opens=0.01)
    cloth = Cloth(vertices=np.array(corners), faces=np.array([[0, 1, 2], [0, 2, 3]]))
    return Scene(cloth=cloth, material=material, table=Table(), grippers=[hand], duration=0.02)


class Unsearched(Simulation):
    """A simulation without the search for contact candidates. The search is compiled by another process."""

    def search(self) -> None:
        """Do nothing instead of searching for candidates."""


@contextmanager
def compiling_beside(folder: str | None = advance.stats.cache_path) -> Iterator[None]:
    """Run `compile_but_search` in a second process while the body of this context runs, and wait for its end.

    No second process is started if kernels are on disk, or if there is only one processor.

    Args:
        folder: Folder of the compiled time stepping; None if compiled functions are not kept on disk.
    """
    if folder is None or any(Path(folder).glob("*.advance-*.nbi")) or processors() < 2:
        yield
        return
    beside = subprocess.Popen([sys.executable, "-c", COMMAND], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
        beside.wait(LONGEST)
    except subprocess.TimeoutExpired:
        pass
    finally:
        beside.kill()
        beside.wait()


def compile_but_search() -> None:
    """Compile the time steps without the search for contact candidates, or load them from disk."""
    for kernel, arguments in calls(Unsearched(smallest_scene()).system):
        kernel.compile(tuple(map(typeof, arguments)))


def calls(system: System) -> list[tuple[Any, tuple[Any, ...]]]:
    """Return the compiled functions (kernels) that the time steps call, each with arguments of the right types."""
    state = system.state
    elastic = system.elastic
    contact = (state.positions, system.mesh, system.contact, system.options)
    seconds = part = speed = 0.0
    return [
        (bending.add_force, (state.Y, state.F, elastic.bending, state.hinges)),
        (membrane.add_force, (state.Y, state.F, elastic.membrane, state.triangle_forces)),
        (membrane.largest_stretch, (state.X, elastic.membrane)),
        (edge_edge.sweep, (*contact, seconds, part)),
        (vertex_face.sweep, (*contact, seconds, part)),
        (rigid.sweep, (*contact[:3], system.bodies, system.options, seconds, part)),
        (impact_zones.hold, contact),
        (
            table.sweep,
            (state.positions, system.mesh.inverse_mass, system.contact, system.plane, system.options, seconds),
        ),
        (air.resist, (state.V, state.F, state.inverse_mass, state.surface, seconds, speed, part)),
        (
            air.meet,
            (state.V, state.surface, system.air, state.positions, system.mesh.faces, state.slot, state.free, seconds),
        ),
    ]
