"""Two fidelities: most trials simulate a coarser mesh, which takes a fraction of the time.

A manipulation keeps its parameters on the coarser mesh: the hands move along the same curves, and they grasp the
nearest vertices. The shape distance D of Eq. (11) is a sum over vertices. Therefore D of the coarser mesh is multiplied
by the ratio of the numbers of vertices.

Large triangles lock: if the cloth curves in two directions, the triangles must stretch instead of bend. The cloth then
appears too stiff. The effect depends on Y h^2 / B, with the stretch stiffness Y, the spacing h and the bending rigidity
B. The cloth of the coarser mesh is therefore softer: its Y is proportional to h^-2. Then both meshes lock equally.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.evaluator import NOTHING, Evaluation, Evaluator, Incumbent, Wrapper
from tatamu.folding.fold import ideal_folds
from tatamu.folding.hand import leaves
from tatamu.folding.interpolation import interpolated
from tatamu.folding.score import vertex_distances
from tatamu.folding.task import Task
from tatamu.garments import Garment, make_garment
from tatamu.search import HIGH, LOW, Parameters
from tatamu.simulation.material import ORTHOTROPIC_MEMBRANE, Material
from tatamu.simulation.simulators import capabilities


@dataclass(frozen=True)
class CoarseMesh:
    """Settings of the coarser mesh: its spacing, and the folds that are simulated on it (docs/notes/learning.md)."""

    one_layer: float = 2.0
    """Ratio of the coarser mesh's spacing to the finer mesh's spacing, for a garment of one layer."""
    two_layers: float = 1.7
    """Ratio of the coarser mesh's spacing to the finer mesh's spacing, for a garment of two layers."""
    several_steps: float = 1.5
    """Ratio of the coarser mesh's spacing to the finer mesh's spacing, for a plan of several steps.

    Loops of earlier folds spring open on larger triangles, so this ratio is smaller."""
    fewest: int = 250
    """Least number of vertices of a coarser mesh.

    If a coarser mesh would have fewer vertices, only the finer mesh is simulated, which then takes little time anyway.
    """
    settle: float = 0.15
    """Time from the opening of the hands until a fold on the coarser mesh is scored [s].

    After this time, the cloth moves little."""
    steps: int = 2
    """Number of first steps of a plan that are simulated on a coarser mesh.

    In later steps the cloth has many layers. There the coarser mesh ranks manipulations poorly, and takes nearly as
    much time as the finer mesh."""

    def ratio(self, garment: Garment, steps: int) -> float:
        """Return the ratio of the coarser mesh's spacing to the finer mesh's spacing."""
        if steps > 1:
            return self.several_steps
        return self.one_layer if garment.layers == 1 else self.two_layers


def coarsened(garment: Garment, larger: float, softer: float) -> Garment:
    """Return a garment on a mesh with larger cells, of cloth that is softer to stretch.

    Args:
        garment: A garment that was made by `make_garment`.
        larger: Ratio of the new spacing to the spacing of `garment`.
        softer: Ratio of the stretch stiffness of `garment` to the new stretch stiffness.

    Raises:
        InputError: If the garment cannot be meshed with these cells, or was not made by `make_garment`.
    """
    source = garment.source
    if source is None:
        raise InputError("garment: must be made by make_garment, so that it can be meshed again")
    material = _soften(garment.material, softer)
    return make_garment(source.name, source.size, material, larger * garment.spacing, source.scale)


def _soften(material: Material, times: float) -> Material:
    """Return a copy of a material whose stretch and shear stiffnesses are divided by `times`."""
    known = {name: getattr(material, name) for name in ("stretch_stiffness", *ORTHOTROPIC_MEMBRANE)}
    return material.model_copy(update={name: value / times for name, value in known.items() if value is not None})


def coarser_task(task: Task, settings: CoarseMesh | None = None) -> Task | None:
    """Return the same task on a coarser mesh; None if the task has no coarser mesh.

    A task has no coarser mesh in these cases:

    - The simulator folds differently on coarser cells.
    - The mesh is already small.
    - The step is a late step of its plan.
    - The garment cannot be meshed or grasped with larger cells.
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
    """Return whether trials of a task end when their hands arrive at the targets, if they cannot become the best.

    The result is true in late steps of plans. Late steps have no coarser mesh, and after the arrival their many layers
    can only come undone. Trials on small meshes run to their end. So do trials on meshes whose spacing the user chose.
    """
    settings = settings or CoarseMesh()
    late = task.number >= settings.steps and not task.garment.spacing_given
    return late and _coarser_garment(task, settings) is not None


def on_coarser_mesh(fine: Task, coarse: Task, parameters: Mapping[str, int | float]) -> Parameters:
    """Return the parameters of the same manipulation on the coarser mesh.

    The curve stays the same, and the hands grasp the nearest vertices.

    Args:
        fine: The task on the finer mesh.
        coarse: The same task on the coarser mesh.
        parameters: Parameters on the finer mesh.
    """
    grasps = fine.manipulation(parameters).grasps
    hands = zip(("g1", "g2"), grasps, (coarse.fold.left, coarse.fold.right), strict=False)
    near = {name: _nearest(fine.fold.start[vertex], coarse.fold.start[side]) for name, vertex, side in hands}
    larger = coarse.fold.span / fine.fold.span
    return {**{name: larger * parameters[name] for name in ("x1", "z1", "x2", "z2")}, "g1": 0, "g2": 0, **near}


def _nearest(point: np.ndarray, points: np.ndarray) -> int:
    """Return the index of that one of n points, shape (n, 3), which is nearest to a given point, seen from above."""
    return int(np.linalg.norm(points[:, :2] - point[:2], axis=1).argmin())


@dataclass(frozen=True)
class CoarseFirst(Wrapper):
    """Evaluates proposals of low fidelity on a coarser mesh, and converts the results to the finer mesh.

    If the task has no coarser mesh (see `coarser_task`), the wrapped evaluator evaluates all proposals.
    """

    settings: CoarseMesh = field(default_factory=CoarseMesh)

    @cached_property
    def coarse(self) -> Evaluator | None:
        """The wrapped evaluator on the coarser mesh; None if the task has no coarser mesh."""
        task = None if self.task.garment.spacing_given else coarser_task(self.task, self.settings)
        return None if task is None else self.inner.on(task)

    @property
    def fidelities(self) -> int:
        """Number of fidelities: 2 if the task has a coarser mesh, otherwise 1."""
        return 1 if self.coarse is None else 2

    @property
    def contains_length(self) -> bool:
        """Whether the trajectory length l_x of Eq. (10) is a part of the objective."""
        return self.inner.contains_length

    def low_fidelity(self, parameters: Mapping[str, int | float]) -> tuple[Evaluator, Parameters] | None:
        """Return the evaluator of the coarser mesh, and the parameters of the same manipulation on this mesh.

        The result is None if the task has no coarser mesh.
        """
        if self.coarse is None:
            return None
        return self.coarse, on_coarser_mesh(self.task, self.coarse.task, parameters)

    @property
    def ratio(self) -> float:
        """Ratio of the shape distance D on the finer mesh to D on the coarser mesh.

        It is the ratio of the numbers of vertices of these meshes.
        """
        assert self.coarse is not None
        return len(self.task.fold.start) / len(self.coarse.task.fold.start)

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the best known evaluation of a proposal's fidelity, with the hardest worlds of both fidelities.

        A world is one random draw of all disturbances.
        """
        fidelity = getattr(parameters, "fidelity", HIGH)
        here = self.inner.incumbent([each for each in known if each.fidelity == fidelity], parameters)
        return replace(here, hardest=self.inner.incumbent(known, parameters).hardest)

    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation. A proposal of low fidelity is evaluated on the coarser mesh."""
        if self.coarse is None:
            return self.inner(parameters, beat)
        if getattr(parameters, "fidelity", HIGH) == LOW:
            return self._low(self.coarse, parameters, beat)
        return self.inner(parameters, beat)

    def _low(self, coarse: Evaluator, parameters: Mapping[str, int | float], beat: Incumbent) -> Evaluation:
        """Evaluate a manipulation on the coarser mesh, and convert the result to the finer mesh.

        The trajectory length l_x is measured on the finer mesh, and the shape distance D is multiplied by `ratio`.
        """
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
        """Return the failed evaluation of a manipulation that is not allowed; None if the manipulation is allowed."""
        refused = self.inner.refuse(parameters)
        return None if refused is None else replace(refused, fidelity=getattr(parameters, "fidelity", HIGH))

    def errors(self, evaluation: Evaluation) -> np.ndarray:
        """Return the vertex distances e_i of Eq. (12) for the n vertices of the task's mesh [m], shape (n,).

        For an evaluation of low fidelity, they are interpolated from the coarser mesh.
        """
        if evaluation.fidelity == HIGH or self.coarse is None or evaluation.rollout is None:
            return self.inner.errors(evaluation)
        final = interpolated(self.coarse.task.garment, evaluation.rollout.positions[-1], self.task.garment)
        return vertex_distances(self.task.fold.target, final)
