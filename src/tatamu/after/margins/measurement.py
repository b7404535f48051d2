"""Measurement of the margins of a learned fold: the disturbances that it tolerates.

Each disturbance is tried alone. In addition, all disturbances are applied together in many random draws.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

from tatamu.after.margins.alone import FARTHEST, Side
from tatamu.base.errors import InputError
from tatamu.base.version import __version__
from tatamu.evaluation import CoarseMesh, Nominal, coarser_task, on_coarser_mesh
from tatamu.evaluation.disturbances import CHANNELS, Disturbances, Stream, World, deviations, mean_world, sample_worlds
from tatamu.evaluation.robustness import (
    AloneMargin,
    FoldOnMesh,
    Judge,
    MarginsResult,
    MeshUsed,
    MeshVerdict,
    Progress,
    Spread,
    SuccessRate,
    Verdict,
    VerdictCache,
    distances_of,
    failures_of,
)
from tatamu.folding.fold import Fold
from tatamu.folding.score import Limits
from tatamu.folding.task import Task
from tatamu.simulation.side_by_side import executor_of, processors
from tatamu.simulation.simulators import capabilities
from tatamu.study.result import Result

DRAWS = 200
"""Default number of joint draws, in which all disturbances have random values."""
KEPT = "simulated.jsonl"
"""Name of the file in which the results of simulations are kept, next to `margins.json`."""


@dataclass(frozen=True)
class Draw:
    """One joint draw: a random value of every disturbance, and the result of the fold."""

    number: int
    world: World
    verdict: Verdict
    """Result of the fold on the finest mesh on which the draw was simulated."""
    distance: float
    """Mean distance of the fine mesh's vertices from their targets [m].

    If only the coarse mesh was simulated, the distance is estimated. The estimate uses draws that were simulated on
    both meshes. If the simulation failed, the distance is twice the distance of untouched cloth."""
    own: bool
    """Whether the draw was simulated on the fine mesh."""


@dataclass(frozen=True)
class Measured:
    """The measured margins of a fold (the disturbances that it tolerates), and more data for the page."""

    learned: Result
    subject: FoldOnMesh
    """The fold on the fine mesh."""
    result: MarginsResult
    draws: list[Draw]
    """Joint draws of all disturbances, from the worst to the best."""

    @property
    def share(self) -> float:
        """Fraction of joint draws in which the fold succeeded."""
        return self.result.joint.share


def measure(
    learned: Result,
    disturbances: Disturbances,
    *,
    out: Path | None = None,
    draws: int = DRAWS,
    seed: int = 0,
    limits: Limits | None = None,
    simulator: str | None = None,
    fine: bool = False,
    alone: bool = True,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Measured:
    """Measure which disturbances a learned fold tolerates, or resume an interrupted measurement.

    Args:
        learned: The fold to measure.
        disturbances: Standard deviations of the disturbances.
        out: Folder in which the results of simulations are kept; None if they are not kept.
        draws: Number of joint draws, in which all disturbances have random values.
        seed: Random seed of the draws.
        limits: Limits of a successful fold; None for the limits that are usual in the field.
        simulator: Name of the simulator; None for the simulator in which the fold was learned.
        fine: Whether to simulate only the fine mesh, even if a coarser mesh exists.
        alone: Whether to also measure the range of each disturbance alone.
        executor: Executor of the simulations. None for threads on all processors, if the simulator supports threads.
        progress: Function that is called after every simulation.

    Raises:
        InputError: If an argument is out of range.
    """
    limits = limits or Limits()
    check_draws(draws, seed)
    if not deviations(disturbances):
        raise InputError("disturbances: must have a deviation above 0, given none")
    task = replace(learned.task, reach=None, simulator=simulator or learned.simulator)
    own = FoldOnMesh(Nominal(task), learned.best.parameters)
    coarser = None if fine or simulator not in (None, learned.simulator) else coarser_fold(own)
    threads = processors() if capabilities(task.simulator).parallel else 1
    worlds = sample_worlds(disturbances, draws, seed, Stream.MARGINS)
    sides = _sides(disturbances) if alone else []
    cache = VerdictCache(None if out is None else out / KEPT)
    centre = mean_world(disturbances)
    with executor_of(executor, threads) as workers:
        judge = Judge(own, coarser, workers, cache, progress)
        found = judge.judge(worlds, limits, lambda: [side.search(limits) for side in sides], centre)
    nominal = found.nominal.verdict
    return Measured(
        learned,
        own,
        MarginsResult(
            tatamu=__version__,
            simulator=task.simulator,
            seed=seed,
            limits=limits,
            undisturbed=nominal.mean_vertex_distance,
            alone=_alone(sides, found.findings if limits.hold(nominal) else [0.0] * len(sides)),
            joint=SuccessRate.of(task.fold, found.worlds, limits),
            moving_vertex_distance=Spread.of(distances_of(task.fold, found.worlds, limits, moving=True)),
            failures=failures_of(found.worlds),
            mesh=_mesh(own, coarser, judge, found.seen, limits),
            simulations=judge.simulations,
            disturbances=disturbances.describe(),
        ),
        _ranked(task.fold, worlds, found.worlds, limits),
    )


def coarser_fold(own: FoldOnMesh) -> FoldOnMesh | None:
    """Return the fold on a coarser mesh; None if the garment has no coarser mesh."""
    task: Task = own.evaluator.task
    coarse = coarser_task(task, CoarseMesh())
    if coarse is None:
        return None
    return FoldOnMesh(Nominal(coarse), on_coarser_mesh(task, coarse, own.parameters))


def check_draws(draws: int, seed: int) -> None:
    """Check that the number of random draws and their seed are within the allowed ranges."""
    if not 1 <= draws <= 100_000:
        raise InputError(f"draws: must be from 1 to 100000, given {draws}")
    if not 0 <= seed < 2**32:
        raise InputError(f"seed: must be from 0 to {2**32 - 1}, given {seed}")


def _sides(disturbances: Disturbances) -> list[Side]:
    """Return two searches for every disturbance: first below its mean, then above its mean."""
    known = deviations(disturbances)
    channels = [channel for channel in CHANNELS if channel.name in known]
    centre = mean_world(disturbances)
    return [Side(channel, known[channel.name], sign, centre) for channel in channels for sign in (-1.0, 1.0)]


def _alone(sides: Sequence[Side], ends: Sequence[float | None]) -> list[AloneMargin]:
    pairs = zip(sides[::2], sides[1::2], ends[::2], ends[1::2], strict=True)
    return [
        AloneMargin(
            name=below.channel.name,
            unit=below.channel.unit,
            low=low,
            high=high,
            deviation=below.deviation,
            mean=below.centre[below.channel.name],
            tried=(below.shown(FARTHEST), above.shown(FARTHEST)),
        )
        for below, above, low, high in pairs
    ]


def _ranked(fold: Fold, worlds: Sequence[World], judged: Sequence[MeshVerdict], limits: Limits) -> list[Draw]:
    """Return the joint draws from the worst to the best."""
    distances = distances_of(fold, judged, limits)
    draws = [
        Draw(number, world, one.verdict, distance, one.fine)
        for number, (world, one, distance) in enumerate(zip(worlds, judged, distances, strict=True))
    ]
    return sorted(draws, key=lambda draw: (-draw.distance, draw.number))


def _mesh(
    own: FoldOnMesh, coarse: FoldOnMesh | None, judge: Judge, seen: Sequence[MeshVerdict], limits: Limits
) -> MeshUsed:
    both = [one.pair for one in seen if one.pair is not None]
    apart = [
        abs(fine.mean_vertex_distance - rough.mean_vertex_distance)
        for fine, rough in both
        if fine.mean_vertex_distance is not None and rough.mean_vertex_distance is not None
    ]
    fold = (coarse or own).evaluator.task.fold
    return MeshUsed(
        spacing=fold.garment.spacing,
        vertices=len(fold.start),
        coarser=coarse is not None,
        own_spacing=own.evaluator.task.garment.spacing,
        own_simulations=judge.fine_simulations,
        checked=len(both),
        same=sum(limits.hold(fine) == limits.hold(rough) for fine, rough in both),
        apart=max(apart, default=0.0),
    )
