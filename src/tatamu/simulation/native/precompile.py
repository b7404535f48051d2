"""Compilation of the kernels that a scene needs, in several processes if they are not on disk.

The compiler has a lock, so threads would wait for each other. Other processes therefore compile the same kernels in
another order, and whoever comes to a kernel that is on disk already loads it.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.native.addresses import Addresses
from tatamu.simulation.native.compiled import address_of, expect, for_types_of, is_on_disk
from tatamu.simulation.native.kernels import Features, addresses, arguments, kernels
from tatamu.simulation.native.options import Options
from tatamu.simulation.native.step import advance
from tatamu.simulation.native.system import Hands, Span, System, initial_system
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tatamu.simulation.side_by_side import processors

COMMAND = f"import sys; from {__name__} import compile_beside; compile_beside(*map(int, sys.argv[1:]))"

_LOADING = Lock()
_loaded: set[Features] = set()


def smallest_scene() -> Scene:
    """Return a short scene of two triangles, whose kernels can be used for every scene."""
    corners = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]]
    material = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5)
    hand = Gripper(vertices=[0], times=[0.0], displacements=np.zeros((1, 3)), opens=0.01)
    cloth = Cloth(vertices=np.array(corners), faces=np.array([[0, 1, 2], [0, 2, 3]]))
    return Scene(cloth=cloth, material=material, table=Table(), grippers=[hand], duration=0.02)


def load(system: System, hands: Hands, frames: np.ndarray) -> tuple[Callable[..., tuple[int, float]], Addresses]:
    """Return the time stepping and the addresses of its kernels; threads take turns in compiling missing ones."""
    features = Features.of(system)
    with _LOADING, compiling_beside(features):
        return for_types_of(advance, (system, hands, frames, Span(0, 0, 1))), addresses(system)


@contextmanager
def compiling_beside(features: Features) -> Iterator[None]:
    """Let other processes compile kernels for these features meanwhile, unless they are on disk or cannot be."""
    missing = [] if features in _loaded else [each for each in kernels(features).values() if not is_on_disk(each)]
    count = min(4, processors(), len(missing)) - 1  # more would wait for the kernel that takes longest
    expect([advance, *missing])
    command = [sys.executable, "-c", COMMAND, *(str(int(each)) for each in features)]
    silent: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    beside = [subprocess.Popen([*command, str(number), str(count)], **silent) for number in range(count)]
    try:
        yield
        _loaded.add(features)
    finally:
        for process in beside:
            process.kill()
            process.wait()


def compile_beside(*given: int) -> None:
    """Compile kernels in reverse order, from the share of one process on: features, its index, and their count."""
    *flags, number, count = given
    needed = kernels(Features(*map(bool, flags)))
    given_to = arguments(initial_system(smallest_scene(), Options()))
    names = list(reversed(needed))
    begin = number * len(names) // count
    for name in names[begin:] + names[:begin]:
        address_of(needed[name], given_to[name])
