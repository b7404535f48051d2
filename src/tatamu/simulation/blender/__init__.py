"""The cloth simulation of Blender, which the ICMA 2019 paper used (docs/theory/blender.md), as a separate process.

`mapping` and `springs` convert a scene to Blender's numbers, `recipe` writes it as plain data, and `process` sends it
through a pipe to `worker`, which runs inside Blender.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.simulation.blender import discovery
from tatamu.simulation.blender.mapping import MAX_FRICTION, SELF_FRICTION, TABLE_FRICTION
from tatamu.simulation.blender.process import WORKERS
from tatamu.simulation.blender.recipe import written
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.side_by_side import side_by_side
from tatamu.simulation.simulators import Capabilities

CAPABILITIES = Capabilities(
    parallel=True,
    compression=True,
    friction_table=MAX_FRICTION / TABLE_FRICTION,
    friction_cloth=MAX_FRICTION / SELF_FRICTION,
)
"""Rollouts can run at the same time, because each uses a Blender process of its own."""


def require() -> None:
    """Raise InputError if no Blender is found."""
    discovery.command()


def prepare() -> None:
    """Do nothing, because Blender starts with the first scene."""


def compilation() -> tuple[int, int]:
    """Return (0, 0), because no function is compiled."""
    return 0, 0


def simulate(scene: Scene) -> Rollout:
    """Simulate one scene; raise SimulationError if it is not finite, or Blender crashes in every attempt."""
    begin = time.perf_counter()
    CAPABILITIES.refuse(scene, "blender")
    recipe = written(scene)
    answer, numbers, version = WORKERS.run(recipe.request)
    moved = recipe.in_scene(numbers.reshape(-1, len(scene.cloth.vertices), 3))
    if not np.isfinite(moved).all():
        frame = 1 + int(np.argmin(np.isfinite(moved).all(axis=(1, 2))))
        raise SimulationError(f"blender: positions are no longer finite after {frame / scene.frame_rate:.3g} s")
    positions = np.concatenate([scene.cloth.vertices[None], moved])
    wall = answer["wall_seconds"]
    lacking = [] if scene.material.blender else CAPABILITIES.lacking(scene.material)
    info = {
        "simulator": "blender",
        "version": version,
        "wall_seconds": wall,
        "setup_seconds": time.perf_counter() - begin - wall,
        "steps": recipe.steps,
        "warnings": [*recipe.warnings, *(f"blender: {line}" for line in lacking)],
    }
    return Rollout(np.arange(scene.frames) / scene.frame_rate, positions, scene.cloth.faces, info)


def simulate_many(scenes: Sequence[Scene]) -> list[Rollout]:
    """Simulate several scenes, with one Blender process per processor core."""
    return side_by_side(simulate, scenes)
