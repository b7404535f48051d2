"""The same job on a coarser mesh, where trials take a part of the time: what carries over, and what to multiply.

A manipulation keeps its parameters: hands move along the same curves, from the nearest vertices. A sum over vertices,
as D of Eq. (11) is, grows with their number; on the finer mesh it would be larger in proportion.

Cells that do not shear lock: what they cannot bend they would have to stretch, and the larger they are for their
stiffness, the stiffer they drape. How much, is a matter of Y h^2 / B, Y being the membrane's stiffness, h the spacing,
B the bending rigidity. So the coarser mesh is softer to stretch, Y proportional to h^-2, and locks as the finer does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tatamu.errors import InputError
from tatamu.folding.fold import ideal_folds
from tatamu.folding.manipulation import Manipulation, bezier_manipulation
from tatamu.folding.task import Job, Outcome, Task
from tatamu.garments import make_garment
from tatamu.material import ORTHOTROPIC_MEMBRANE, Material
from tatamu.simulators import capabilities

COARSER = {1: 2.0, 2: 1.7}
"""Spacing of the coarser mesh over that of the finer one, by the garment's layers (docs/notes/learning.md)."""
OF_SEVERAL_STEPS = 1.5
"""Likewise of a plan of several steps, whatever the layers: cells are then three quarters of a bending length; on
larger ones more loops of earlier folds spring open (docs/notes/learning.md)."""
FEWEST = 250
"""A coarser mesh has at least this many vertices; smaller folds take no time to speak of."""
SOON = 0.15
"""After opening, until a fold on the coarser mesh is scored [s]: it moves little later."""


def with_coarser(job: Job) -> Job:
    """The job with its coarser mesh, where it has one and the user did not choose the spacing."""
    if job.asked is None or job.asked.spacing is not None:
        return job
    return replace(job, coarser=on_coarser_cells(job))


def on_coarser_cells(job: Job) -> Job | None:
    """The job on a coarser mesh.

    It has none where the simulator folds differently on coarser cells, where the mesh is small already, and where the
    garment cannot be meshed or grasped with larger cells.
    """
    if job.asked is None or not capabilities(job.simulator).coarse_search:
        return None
    larger = COARSER[job.garment.layers] if len(job.plan.steps) == 1 else OF_SEVERAL_STEPS
    try:
        coarser = coarsened(job, larger, larger**2)
    except InputError:
        return None
    if not FEWEST <= len(coarser.garment.vertices) < len(job.garment.vertices):
        return None
    return coarser


def coarsened(job: Job, larger: float, softer: float) -> Job:
    """The job on cells so many times larger, of cloth so many times softer to stretch.

    Raises:
        InputError: The garment cannot be meshed so, or not be grasped.
    """
    asked = job.asked
    assert asked is not None, "the job has a garment by name"
    garment = job.garment
    material = _softer(garment.material, softer)
    coarse = make_garment(asked.garment, asked.size_pair, material, larger * garment.spacing, asked.scale)
    ideal_folds(coarse, job.plan, job.hands)
    return replace(job, garment=coarse)


def _softer(material: Material, times: float) -> Material:
    """A material that is so many times softer to stretch and to shear."""
    known = {name: getattr(material, name) for name in ("stretch_stiffness", *ORTHOTROPIC_MEMBRANE)}
    return material.model_copy(update={name: value / times for name, value in known.items() if value is not None})


def on_coarser_mesh(task: Task, manipulation: Manipulation, parameters: Mapping[str, float]) -> Manipulation:
    """The manipulation of the same parameters on the coarser mesh of a task, which is scored soon after it."""
    coarse = task.coarser
    assert coarse is not None, "the task has a coarser mesh"
    grasps = tuple(
        _nearest(task.fold.start[vertex], coarse.fold.start, candidates)
        for vertex, candidates in zip(manipulation.grasps, (coarse.fold.left, coarse.fold.right), strict=False)
    )
    larger = coarse.fold.span / task.fold.span
    inner = (larger * parameters[name] for name in ("x1", "z1", "x2", "z2"))
    return replace(bezier_manipulation(coarse.fold, grasps, *inner), settle=SOON)


def as_on_finer_mesh(task: Task, manipulation: Manipulation, coarse: Manipulation, found: Outcome) -> Outcome:
    """The outcome on the coarser mesh in the numbers of the finer one: l_x is the finer one's, D grows with vertices.

    Args:
        task: On the finer mesh.
        manipulation: On the finer mesh.
        coarse: The manipulation on the coarser mesh.
        found: The outcome there.
    """
    larger = larger_on_finer_mesh(task)
    length = manipulation.trajectory_length
    objective = length + larger * (found.objective - coarse.trajectory_length)
    if found.score is None:
        return replace(found, objective=objective)
    score = replace(
        found.score,
        objective=objective,
        trajectory_length=length,
        shape_distance=larger * found.score.shape_distance,
    )
    return replace(found, objective=objective, score=score)


def objective_on_coarser_mesh(task: Task, manipulation: Manipulation, coarse: Manipulation, objective: float) -> float:
    """The objective on the coarser mesh that is this one in the numbers of the finer: `as_on_finer_mesh` backwards."""
    larger = larger_on_finer_mesh(task)
    return coarse.trajectory_length + (objective - manipulation.trajectory_length) / larger


def larger_on_finer_mesh(task: Task) -> float:
    """D on a task's own mesh over D on its coarser one: a sum over vertices grows with their number."""
    assert task.coarser is not None, "the task has a coarser mesh"
    return len(task.fold.start) / len(task.coarser.fold.start)


def _nearest(point: np.ndarray, points: np.ndarray, candidates: np.ndarray) -> int:
    """The candidate vertex that lies nearest to a point, seen from above."""
    return int(candidates[np.linalg.norm(points[candidates, :2] - point[:2], axis=1).argmin()])
