"""Simulate the learned fold again: by the robot's hands as they moved in the rehearsal, and by floating hands.

Floating hands move exactly as learned, without a robot. Both simulations use the mesh of the learned fold, or a finer
mesh if the simulator needs a finer mesh. All vertices of the learned mesh are also vertices of the finer mesh. Shapes
are therefore always compared and scored on the learned mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.score import Score
from tatamu.robots.rehearsal import Rehearsal
from tatamu.robots.rehearsed_scene import rehearsed_scene
from tatamu.simulation.mesh.subdivision import on_coarse_mesh, subdivided
from tatamu.simulation.mesh.topology import Topology, edge_lengths
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import capabilities, named
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result

MOST_HALVINGS = 2
"""Largest number of times that the edges of a mesh are halved. Each halving divides a triangle into four triangles."""


@dataclass(frozen=True)
class Refold:
    """Two simulated motions of one fold, on the mesh of the learned fold."""

    simulator: str
    halvings: int
    """Number of times that the edges of the learned mesh were halved for the simulation."""
    simulated_vertices: int
    scene: Scene
    """The scene with the robot's hands."""
    robot: Rollout
    floating: Rollout
    """The fold by floating hands. The hands move at the learned speed, which may be higher than the robot's speed."""
    target: np.ndarray | None
    """The wanted positions of all n vertices [m], shape (n, 3); None if the plan does not contain these positions."""
    learned: Result | None = None
    """The learned fold with its task, which is needed to score folds; None if the fold cannot be scored."""
    unscored: str | None = None
    """Reason why the fold cannot be scored; None if the fold can be scored."""

    @property
    def apart(self) -> np.ndarray:
        """Distance of each vertex between the final shapes of both folds [m], shape (n,).

        One fold is by the robot's hands, the other fold is by floating hands.
        """
        return np.asarray(np.linalg.norm(self.robot.positions[-1] - self.floating.positions[-1], axis=1))

    @property
    def scores(self) -> dict[str, Score]:
        """Scores of three folds: by the robot, by floating hands, and the learned fold.

        Empty if they cannot be scored.
        """
        if self.learned is None:
            return {}
        return {
            "robot": self.learned.rate(self.robot.positions[-1]),
            "floating": self.learned.rate(self.floating.positions[-1]),
            "learned": self.learned.score,
        }


def halvings_for(scene: Scene, simulator: str) -> int:
    """Return how many times the edges of a scene's mesh must be halved, so that the simulator can use the mesh."""
    coarsest = capabilities(simulator).usable_cell or np.inf
    lengths = edge_lengths(scene.cloth.rest, Topology(scene.cloth.faces).edges)
    cells = lengths.mean() / max(scene.material.bending_length, 1e-9)
    needed = int(np.ceil(np.log2(max(cells / coarsest, 1e-9))))
    return min(max(0, needed), MOST_HALVINGS)


def refold(rehearsal: Rehearsal, simulator: str, halvings: int | None = None) -> Refold | None:
    """Simulate the fold with the robot's hands and with floating hands. Return None if the plan contains no scene.

    Args:
        rehearsal: Motion of the robot.
        simulator: Name of the simulator.
        halvings: Number of times that the mesh's edges are halved; None for the number that the simulator needs.

    Raises:
        InputError: If no simulator has this name, or a file of the fold is broken.
        SimulationError: If the simulation failed.
    """
    folder = rehearsal.planned.fold
    if not folder.scene_file.is_file():
        return None
    learned = folder.scene
    engine = named(simulator)
    scene = rehearsed_scene(rehearsal, learned)
    count = halvings_for(learned, simulator) if halvings is None else halvings
    both = [subdivided(one, count) for one in (scene, learned)]
    robot, floating = (on_coarse_mesh(fine, learned.cloth.faces) for fine in engine.simulate_many(both))
    known, why_not = _rebuilt(folder)
    target = _target(folder, len(learned.cloth.vertices))
    return Refold(simulator, count, len(both[0].cloth.vertices), scene, robot, floating, target, known, why_not)


def _target(folder: ResultFolder, count: int) -> np.ndarray | None:
    target = folder.rollout.extra.get("target") if folder.rollout_file.is_file() else None
    return target if target is not None and target.shape == (count, 3) else None


def _rebuilt(folder: ResultFolder) -> tuple[Result | None, str | None]:
    """Return the learned fold from the plan's folder, and the reason why the fold cannot be scored.

    One of them is None.
    """
    if not folder.result_file.is_file():
        return None, "the plan carries no result.json of the learned fold"
    try:
        return Result.load(folder.path), None
    except InputError as error:
        return None, str(error)
