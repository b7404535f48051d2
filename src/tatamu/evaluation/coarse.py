"""Two fidelities: most trials simulate a coarser mesh, because this takes a fraction of the time.

A manipulation keeps its parameters on the coarser mesh: the hands move along the same curves, from the nearest
vertices. D of Eq. (11) is a sum over vertices, so it is scaled to the number of vertices of the finer mesh.

Large triangles lock: where the cloth curves in two directions, they must stretch instead of bend, so the cloth appears
too stiff. The effect depends on Y h^2 / B, with the stretch stiffness Y, the spacing h and the bending rigidity B. The
cloth of the coarser mesh is therefore softer to stretch, with Y proportional to h^-2. Both meshes then lock equally.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tatamu.errors import InputError
from tatamu.evaluation.evaluator import NOTHING, Evaluation, Evaluator, Incumbent, Wrapper
from tatamu.folding.fold import ideal_folds
from tatamu.folding.hand import leaves
from tatamu.folding.interpolation import interpolated
from tatamu.folding.score import vertex_distances
from tatamu.folding.task import Task
from tatamu.garments import Garment, make_garment
from tatamu.material import ORTHOTROPIC_MEMBRANE, Material
from tatamu.search import HIGH, LOW, Parameters
from tatamu.simulators import capabilities


@dataclass(frozen=True)
class CoarseMesh:
    """The spacing of the coarser mesh, and which folds are simulated on a coarser mesh (docs/notes/learning.md)."""

    one_layer: float = 2.0
    """Ratio of the spacings of the coarser and the finer mesh, for a garment of one layer."""
    two_layers: float = 1.7
    """The same ratio for a garment of two layers."""
    several_steps: float = 1.5
    """The same ratio for a plan of several steps, because loops of earlier folds spring open on larger triangles."""
    fewest: int = 250
    """Least number of vertices of a coarser mesh; smaller folds take little time anyway."""
    settle: float = 0.15
    """Time from the opening of the hands until a fold on the coarser mesh is scored [s]; later the cloth moves
    little."""
    steps: int = 2
    """Number of first steps of a plan that are simulated on a coarser mesh. In later steps the cloth has many layers.
    There the coarser mesh ranks manipulations poorly, and takes most of the finer mesh's time."""

    def ratio(self, garment: Garment, steps: int) -> float:
        """Return the ratio of the spacings of the coarser and the finer mesh."""
        if steps > 1:
            return self.several_steps
        return self.one_layer if garment.layers == 1 else self.two_layers


def coarsened(garment: Garment, larger: float, softer: float) -> Garment:
    """Return a garment on larger cells, of cloth that is softer to stretch.

    Args:
        garment: Made by `make_garment`.
        larger: Ratio of the new spacing to that of `garment`.
        softer: Ratio of the stretch stiffness of `garment` to that of the result.

    Raises:
        InputError: If the garment cannot be meshed so, or was not made by `make_garment`.
    """
    source = garment.source
    if source is None:
        raise InputError("garment: must be made by make_garment, so that it can be meshed again")
    material = _soften(garment.material, softer)
    return make_garment(source.name, source.size, material, larger * garment.spacing, source.scale)


def _soften(material: Material, times: float) -> Material:
    """Return a material that is softer to stretch and to shear."""
    known = {name: getattr(material, name) for name in ("stretch_stiffness", *ORTHOTROPIC_MEMBRANE)}
    return material.model_copy(update={name: value / times for name, value in known.items() if value is not None})


def coarser_task(task: Task, settings: CoarseMesh | None = None) -> Task | None:
    """Return the same task on a coarser mesh; None if the task has no coarser mesh.

    A task has no coarser mesh if the simulator folds differently on coarser cells, if the mesh is small already, or if
    the step is a late one of its plan. It has no coarser mesh either if the garment cannot be meshed or grasped with
    larger cells.
    """
    settings = settings or CoarseMesh()
    if task.number >= settings.steps:
        return None
    garment = _coarser_garment(task, settings)
    if garment is None:
        return None
    state = None if task.state is None else interpolated(task.garment, task.state, garment)
    coarse = replace(task, garment=garment, state=state, settle=settings.settle + leaves(task.fingers), reach=None)
    try:
        _ = coarse.fold
    except InputError:
        return None
    return coarse


def _coarser_garment(task: Task, settings: CoarseMesh) -> Garment | None:
    if task.garment.source is None or not capabilities(task.simulator).coarse_search:
        return None
    larger = settings.ratio(task.garment, len(task.plan.steps))
    try:
        garment = coarsened(task.garment, larger, larger**2)
        ideal_folds(garment, task.plan, task.hands)
    except InputError:
        return None
    return garment if settings.fewest <= len(garment.vertices) < len(task.garment.vertices) else None


def ends_early(task: Task, settings: CoarseMesh | None = None) -> bool:
    """Return whether a trial that cannot become the best ends when its hands arrive: true in late steps of plans.

    Late steps have no coarser mesh. Their many layers only come undone after the hands have arrived. Trials on small
    meshes, and on meshes whose spacing the user chose, run to their end.
    """
    settings = settings or CoarseMesh()
    late = task.number >= settings.steps and not task.garment.spacing_given
    return late and _coarser_garment(task, settings) is not None


def on_coarser_mesh(fine: Task, coarse: Task, parameters: Mapping[str, int | float]) -> Parameters:
    """Return the parameters of the same manipulation on the coarser mesh: the same curve, from the nearest grasps.

    Args:
        fine: The task.
        coarse: The same task on the coarser mesh.
        parameters: Parameters on the finer mesh.
    """
    grasps = fine.manipulation(parameters).grasps
    hands = zip(("g1", "g2"), grasps, (coarse.fold.left, coarse.fold.right), strict=False)
    near = {name: _nearest(fine.fold.start[vertex], coarse.fold.start[side]) for name, vertex, side in hands}
    larger = coarse.fold.span / fine.fold.span
    return {**{name: larger * parameters[name] for name in ("x1", "z1", "x2", "z2")}, "g1": 0, "g2": 0, **near}


def _nearest(point: np.ndarray, points: np.ndarray) -> int:
    """Return the number of the point (n, 3) that lies nearest to another, seen from above."""
    return int(np.linalg.norm(points[:, :2] - point[:2], axis=1).argmin())


@dataclass(frozen=True)
class CoarseFirst(Wrapper):
    """Evaluates proposals of low fidelity on a coarser mesh, and converts the results to the finer mesh.

    If the task has no coarser mesh (see `coarser_task`), all proposals go to the inner evaluator.
    """

    settings: CoarseMesh = field(default_factory=CoarseMesh)

    @cached_property
    def coarse(self) -> Evaluator | None:
        """The inner evaluator on the coarser mesh; None if the task has no coarser mesh."""
        task = None if self.task.garment.spacing_given else coarser_task(self.task, self.settings)
        return None if task is None else self.inner.on(task)

    @property
    def fidelities(self) -> int:
        """2 if there is a coarser mesh, otherwise 1."""
        return 1 if self.coarse is None else 2

    @property
    def contains_length(self) -> bool:
        """Whether l_x of Eq. (10) is a part of the objective."""
        return self.inner.contains_length

    def low_fidelity(self, parameters: Mapping[str, int | float]) -> tuple[Evaluator, Parameters] | None:
        """Return the evaluator of the coarser mesh, and the same manipulation's parameters there; None without one."""
        if self.coarse is None:
            return None
        return self.coarse, on_coarser_mesh(self.task, self.coarse.task, parameters)

    @property
    def ratio(self) -> float:
        """D on the finer mesh over D on the coarser one: the ratio of their numbers of vertices."""
        assert self.coarse is not None
        return len(self.task.fold.start) / len(self.coarse.task.fold.start)

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the best evaluation of the same fidelity, with the hardest worlds of both."""
        fidelity = getattr(parameters, "fidelity", HIGH)
        here = self.inner.incumbent([each for each in known if each.fidelity == fidelity], parameters)
        return replace(here, hardest=self.inner.incumbent(known, parameters).hardest)

    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation; proposals of low fidelity on the coarser mesh."""
        if self.coarse is None:
            return self.inner(parameters, beat)
        if getattr(parameters, "fidelity", HIGH) == LOW:
            return self._low(self.coarse, parameters, beat)
        return self.inner(parameters, beat)

    def _low(self, coarse: Evaluator, parameters: Mapping[str, int | float], beat: Incumbent) -> Evaluation:
        """Evaluate on the coarser mesh, with l_x of the finer mesh, and with D multiplied by `ratio`."""
        there = on_coarser_mesh(self.task, coarse.task, parameters)
        length = self.task.manipulation(parameters).trajectory_length
        coarse_length = coarse.task.manipulation(there).trajectory_length
        scaled = Incumbent(coarse_length + (beat.objective - length) / self.ratio, beat.cost / self.ratio, beat.hardest)
        found = coarse(there, scaled)
        nominal = length + self.ratio * (found.nominal - coarse_length)
        changes = {"objective": nominal, "trajectory_length": length}
        if found.score is not None:
            changes["shape_distance"] = self.ratio * found.score.shape_distance
        return replace(
            found,
            parameters=dict(parameters),
            trajectory_length=length,
            objective=nominal + self.ratio * found.cost,
            nominal=nominal,
            score=None if found.score is None else found.score.model_copy(update=changes),
            fidelity=LOW,
        )

    def fail(self, parameters: Mapping[str, int | float], error: str) -> Evaluation:
        """Return the evaluation of a manipulation that could not be simulated."""
        return replace(self.inner.fail(parameters, error), fidelity=getattr(parameters, "fidelity", HIGH))

    def refuse(self, parameters: Mapping[str, int | float]) -> Evaluation | None:
        """Return an evaluation that needs no simulation, since the manipulation is not allowed; None if it is."""
        refused = self.inner.refuse(parameters)
        return None if refused is None else replace(refused, fidelity=getattr(parameters, "fidelity", HIGH))

    def errors(self, evaluation: Evaluation) -> np.ndarray:
        """Return e_i of Eq. (12) [m] on the task's mesh, shape (n,); of low fidelity interpolated to its vertices."""
        if evaluation.fidelity == HIGH or self.coarse is None or evaluation.rollout is None:
            return self.inner.errors(evaluation)
        final = interpolated(self.coarse.task.garment, evaluation.rollout.positions[-1], self.task.garment)
        return vertex_distances(self.task.fold.target, final)
