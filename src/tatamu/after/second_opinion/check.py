"""Simulates the best manipulation of a learned fold again in another simulator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.base.version import __version__
from tatamu.folding.score import Score
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.meshing import before_subdivision, subdivided
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import named
from tatamu.study.result import Result


@dataclass(frozen=True)
class Opinion:
    """The result of simulating a learned fold in another simulator."""

    learned: Result
    simulator: str
    scene: Scene
    """Scene that was simulated."""
    rollout: Rollout | None
    """Motion of the learned fold's vertices in the other simulator; None if the simulation failed."""
    score: Score | None
    error: str | None
    """Reason why the simulation failed; None if it succeeded."""

    def __repr__(self) -> str:
        ends = self.error if self.score is None else f"{1e3 * self.score.mean_vertex_distance:.1f} mm from the target"
        return f"<Opinion of {self.simulator} on {self.learned.name}: {'succeeds' if self.holds else 'fails'}, {ends}>"

    @property
    def apart(self) -> np.ndarray:
        """Distance between the final positions of each vertex in both simulators [m], shape (n,)."""
        assert self.rollout is not None
        return np.asarray(np.linalg.norm(self.rollout.positions[-1] - self.learned.final, axis=1))

    @property
    def holds(self) -> bool:
        """Whether the fold meets the thresholds of success in the other simulator."""
        return self.score is not None and self.score.succeeds

    def to_json(self) -> dict[str, Any]:
        """Return the result as a dictionary for the file `check.json`."""
        info = self.rollout.info if self.rollout else {}
        between = None
        if self.rollout is not None:
            between = {"mean": float(self.apart.mean()), "largest": float(self.apart.max())}
        return {
            "version": 1,
            "tatamu": __version__,
            "garment": self.learned.record.task.garment,
            "fold": self.learned.record.task.fold,
            "learned_in": self.learned.simulator,
            "checked_in": self.simulator,
            "vertices_simulated": len(self.scene.cloth.vertices),
            "material": self.scene.material.model_dump(),
            "holds": self.holds,
            "error": self.error,
            "distance_between_final_shapes": between,
            "learned": self.learned.score.model_dump(),
            "checked": self.score.model_dump() if self.score else None,
            "warnings": info.get("warnings", []),
            "wall_seconds": info.get("wall_seconds"),
        }


def check(learned: Result, simulator: str, material: Material | None = None, halved: bool = False) -> Opinion:
    """Simulate the best manipulation of a learned fold again in another simulator.

    Args:
        learned: Learned fold.
        simulator: Name of the other simulator.
        material: Material of the cloth in the other simulator; None for the material of the learned fold.
        halved: Whether to simulate on a mesh of half the spacing.

    Raises:
        InputError: If there is no simulator with this name, or the simulator cannot run here.
    """
    scene = modify_scene(learned.scene, material, halved)
    try:
        rollout = named(simulator).simulate(scene)
    except SimulationError as error:
        return Opinion(learned, simulator, scene, None, None, str(error))
    rollout = before_subdivision(rollout, learned.faces)
    return Opinion(learned, simulator, scene, rollout, learned.rate(rollout.positions[-1]), None)


def modify_scene(scene: Scene, material: Material | None, halved: bool) -> Scene:
    """Return a scene with another material, with half the mesh spacing, or with both changes.

    If the other material has another thickness, the height of the cloth is adapted.
    """
    if material is not None:
        raised = scene.cloth.vertices * [1.0, 1.0, material.thickness / scene.material.thickness]
        rest = scene.cloth.rest_vertices
        cloth = scene.cloth.model_copy(update={"vertices": raised, "rest_vertices": rest})
        scene = scene.model_copy(update={"material": material, "cloth": cloth})
    return subdivided(scene) if halved else scene
