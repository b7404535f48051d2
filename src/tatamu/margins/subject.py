"""The fold whose margins are measured: its task, its manipulation and the mesh that it is simulated on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

import numpy as np

from tatamu import curves
from tatamu.disturbances import CALM, Limits, Verdict, judge
from tatamu.errors import InputError
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation, scene_of
from tatamu.folding.task import Task
from tatamu.garments.resolution import largest_spacing
from tatamu.results import ManipulationDescription, RebuiltFold, rebuild

CELLS = 1.0
"""Spacing of the coarse mesh, in bending lengths: on it a fold fails in the same worlds (docs/notes/margins.md)."""
SAME = 0.002
"""The coarse mesh is used where both meshes leave the undisturbed fold this near to one another [m]."""


@dataclass(frozen=True)
class FoldOnMesh:
    """A manipulation of a fold on some mesh."""

    task: Task
    manipulation: Manipulation

    @property
    def key(self) -> str:
        """A name that differs where a simulation would."""
        scene = scene_of(self.task.fold, self.manipulation)
        return sha256(f"{self.task.simulator} {scene.model_dump_json()}".encode()).hexdigest()[:16]


def subject_of(folder: Path, simulator: str | None = None) -> tuple[RebuiltFold, FoldOnMesh]:
    """The learned fold in a folder on its own mesh, in the simulator of that name; None: where it was learned.

    Raises:
        InputError: The folder holds no learned fold that can be built again.
    """
    learned = rebuild(folder)
    task = replace(learned.task, reach=None, simulator=simulator or learned.task.simulator)
    return learned, FoldOnMesh(task, _manipulation(learned.fold.manipulation, task.fold))


def _manipulation(description: ManipulationDescription, fold: Fold) -> Manipulation:
    """The manipulation that `manipulation.json` describes, to the last digit that it has."""
    grasps = tuple(arm.grasp.vertex for arm in description.arms)
    places = tuple(fold.start[vertex] for vertex in grasps)
    points = tuple(np.asarray(arm.control_points) - arm.control_points[0] for arm in description.arms)
    lift = float(description.arms[0].control_points[0][2]) - description.arms[0].grasp.position[2]
    return Manipulation(grasps, places, tuple(map(curves.sampled_bezier, points)), points, max(0.0, lift))


def on_mesh(subject: FoldOnMesh, task: Task) -> FoldOnMesh:
    """The same manipulation of the same fold on another mesh: grasps at the nearest candidates, the same curves.

    Raises:
        InputError: The manipulation follows no Bezier curves.
    """
    if subject.manipulation.control_points is None:
        raise InputError("manipulation: must be on Bezier curves")
    fold = task.fold
    grasps: list[int] = []
    points = []
    hands = zip(subject.manipulation.positions, subject.manipulation.control_points, strict=True)
    for (position, control), candidates in zip(hands, (fold.left, fold.right), strict=False):
        away = np.linalg.norm(fold.start[candidates] - position, axis=1)
        vertex = int(candidates[away.argmin()])
        grasps.append(vertex)
        points.append(_fitted(control, fold.translation(vertex)))
    places = tuple(fold.start[vertex] for vertex in grasps)
    moved = Manipulation(tuple(grasps), places, tuple(map(curves.sampled_bezier, points)), tuple(points), fold.lift)
    return FoldOnMesh(task, moved)


def _fitted(control: np.ndarray, release: np.ndarray) -> np.ndarray:
    """Control points (4, 3) [m] that end at another release, larger in proportion."""
    before = float(np.linalg.norm(control[-1, :2]))
    larger = float(np.linalg.norm(release[:2])) / before if before else 1.0
    fitted = control * larger
    fitted[-1] = release
    return fitted


def coarse(learned: RebuiltFold, subject: FoldOnMesh, limits: Limits) -> FoldOnMesh | None:
    """The subject on a coarse mesh; None where there is none on which the undisturbed fold ends alike."""
    garment = subject.task.fold.garment
    spacing = min(CELLS * garment.material.bending_length, largest_spacing(garment.size))
    if subject.task.step[0] > 1 or garment.own or spacing < 1.2 * garment.spacing:
        return None
    try:
        task = replace(learned.on_spacing(spacing), simulator=subject.task.simulator)
        moved = on_mesh(subject, task)
    except InputError:
        return None
    return moved if _alike(judge(moved.task, moved.manipulation, CALM), learned, limits) else None


def _alike(found: Verdict, learned: RebuiltFold, limits: Limits) -> bool:
    known = learned.score.mean_vertex_distance
    near = found.mean_vertex_distance is not None and abs(found.mean_vertex_distance - known) < SAME
    return near and found.holds(limits)
