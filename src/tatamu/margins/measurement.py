"""Margins of a learned fold: each disturbance alone, and all of them at once in many draws."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

from tatamu import __version__
from tatamu.disturbances import (
    CHANNELS,
    Asker,
    Disturbances,
    FoldOnMesh,
    Judged,
    Limits,
    Memory,
    Progress,
    Stream,
    Verdict,
    World,
    deviations,
    drawn,
    settled,
)
from tatamu.errors import InputError
from tatamu.folding.task import Task
from tatamu.margins.alone import FARTHEST, Side
from tatamu.margins.subject import coarse, subject_of
from tatamu.results import RebuiltFold
from tatamu.results.joint import distances_of, joint_margin
from tatamu.results.margins import AloneMargin, HoldLimits, MarginsResult, MeshUsed
from tatamu.simulators import capabilities
from tatamu.simulators.many import executor_of, processors

DRAWS = 200
"""How many joint draws there are unless somebody asks for another number."""
KEPT = "simulated.jsonl"
"""The file that keeps simulations, beside `margins.json`."""


@dataclass(frozen=True)
class Draw:
    """One joint draw."""

    number: int
    world: World
    verdict: Verdict
    """On the finest mesh that it was simulated on."""
    distance: float
    """Mean vertex distance on the fold's own mesh [m]; where it was not simulated there, what pairs of both meshes say;
    where the simulation failed, twice that of untouched cloth."""
    own: bool
    """Whether it was simulated on the fold's own mesh."""


@dataclass(frozen=True)
class Measured:
    """Margins, and what a page shows beside them."""

    learned: RebuiltFold
    subject: FoldOnMesh
    """On its own mesh."""
    result: MarginsResult
    draws: list[Draw]
    """From the worst to the best."""


def measure(
    folder: Path,
    disturbances: Disturbances,
    *,
    out: Path,
    draws: int = DRAWS,
    seed: int = 0,
    limits: Limits | None = None,
    simulator: str | None = None,
    fine: bool = False,
    alone: bool = True,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Measured:
    """Measure the margins of a learned fold, or go on where it was interrupted.

    Args:
        folder: The learned fold's.
        disturbances: What is not known, and how far it may be off.
        out: Where simulations are kept.
        draws: How many joint draws.
        seed: Of the draws.
        limits: What the fold must keep in order to hold; None: the field's.
        simulator: In which simulator; None: where it was learned.
        fine: On the fold's own mesh, even where a coarser one does.
        alone: Also search how far each disturbance alone may go.
        executor: Where simulations run; None: threads on every processor, where the simulator can.
        progress: Called after every simulation.

    Raises:
        InputError: An argument is out of range, or the folder holds no learned fold.
    """
    limits = limits or Limits()
    check_draws(draws, seed)
    if not deviations(disturbances):
        raise InputError("disturbances: must have a deviation above 0, given none")
    learned, own = subject_of(folder, simulator)
    coarser = None if fine or simulator not in (None, learned.simulator) else coarse(learned, own)
    threads = processors() if capabilities(own.task.simulator).parallel else 1
    worlds = drawn(disturbances, draws, seed, Stream.MARGINS)
    sides = _sides(disturbances) if alone else []
    with executor_of(executor, threads) as workers:
        asker = Asker(own, coarser, workers, Memory(out / KEPT), progress)
        found = settled(asker, worlds, limits, lambda: [side.search(limits) for side in sides])
    calm = found.calm.verdict
    return Measured(
        learned,
        own,
        MarginsResult(
            tatamu=__version__,
            simulator=own.task.simulator,
            seed=seed,
            limits=HoldLimits(mean_vertex_distance=limits.mean_vertex_distance, mask_iou=limits.mask_iou),
            undisturbed=calm.mean_vertex_distance,
            alone=_alone(sides, found.ends if calm.holds(limits) else [0.0] * len(sides)),
            joint=joint_margin(own.task, found.judged, limits),
            mesh=_mesh(own, coarser, asker, found.pairs, limits),
            simulations=asker.asked,
            disturbances=disturbances.describe(),
        ),
        _ranked(own.task, worlds, found.judged, limits),
    )


def check_draws(draws: int, seed: int) -> None:
    """Refuse draws that cannot be."""
    if not 1 <= draws <= 100_000:
        raise InputError(f"draws: must be from 1 to 100000, given {draws}")
    if not 0 <= seed < 2**32:
        raise InputError(f"seed: must be from 0 to {2**32 - 1}, given {seed}")


def _sides(disturbances: Disturbances) -> list[Side]:
    """Every disturbance in both directions, below zero before above."""
    known = deviations(disturbances)
    channels = [channel for channel in CHANNELS if channel.name in known]
    return [Side(channel, known[channel.name], sign) for channel in channels for sign in (-1.0, 1.0)]


def _alone(sides: Sequence[Side], ends: Sequence[float | None]) -> list[AloneMargin]:
    pairs = zip(sides[::2], sides[1::2], ends[::2], ends[1::2], strict=True)
    return [
        AloneMargin(
            name=below.channel.name,
            unit=below.channel.unit,
            low=low,
            high=high,
            deviation=below.deviation,
            tried=(below.shown(FARTHEST), above.shown(FARTHEST)),
        )
        for below, above, low, high in pairs
    ]


def _ranked(task: Task, worlds: Sequence[World], judged: Sequence[Judged], limits: Limits) -> list[Draw]:
    """Draws from the worst to the best."""
    distances = distances_of(task, judged, limits)
    draws = [
        Draw(number, world, one.verdict, distance, one.own)
        for number, (world, one, distance) in enumerate(zip(worlds, judged, distances, strict=True))
    ]
    return sorted(draws, key=lambda draw: (-draw.distance, draw.number))


def _mesh(
    own: FoldOnMesh, coarse: FoldOnMesh | None, asker: Asker, pairs: Sequence[Judged], limits: Limits
) -> MeshUsed:
    both = [(pair.verdict, pair.coarse) for pair in pairs if pair.coarse is not None]
    apart = [
        abs(one.mean_vertex_distance - other.mean_vertex_distance)
        for one, other in both
        if one.mean_vertex_distance is not None and other.mean_vertex_distance is not None
    ]
    fold = (coarse or own).task.fold
    return MeshUsed(
        spacing=fold.garment.spacing,
        vertices=len(fold.start),
        coarser=coarse is not None,
        own_spacing=own.task.fold.garment.spacing,
        own_simulations=asker.asked_of_own,
        checked=len(both),
        same=sum(one.holds(limits) == other.holds(limits) for one, other in both),
        apart=max(apart, default=0.0),
    )
