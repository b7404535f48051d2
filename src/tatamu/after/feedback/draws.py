"""Simulated draws with which observations are compared: the draws of `tatamu margins`, and wider draws.

A draw is one random value of each disturbance. It gives a world, in which the fold is simulated. `tatamu margins` and
`tatamu observe` save their simulations in the same file. Therefore a world that one of the commands has simulated is
not simulated again by the other.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tatamu.after.margins.measurement import KEPT, coarser_fold
from tatamu.evaluation import Nominal
from tatamu.evaluation.disturbances import Disturbances, Stream, World, mean_world, sample_worlds
from tatamu.evaluation.robustness import FoldOnMesh, Verdict, VerdictCache, simulate_missing
from tatamu.folding.marks import MARKS
from tatamu.simulation.side_by_side import executor_of, processors
from tatamu.simulation.simulators import capabilities
from tatamu.study.result import Result

USUAL = 100
"""Number of draws with the standard deviations that the user gave.

They are equal to the first draws of `tatamu margins`.
"""
WIDE = 100
"""Number of draws with larger standard deviations than the user gave.

They also cover a set-up whose errors are larger than the user stated.
"""
WIDER = 2.0
"""Ratio of the standard deviations of the wider draws to those that the user gave."""

Progress = Callable[[int, int], None]
"""Callback with two numbers: finished simulations, and all simulations."""


@dataclass(frozen=True)
class Draws:
    """Worlds (random draws of the disturbances), and the results of a fold in them."""

    mesh: FoldOnMesh
    """The fold on the mesh on which all draws of the disturbances were simulated."""
    worlds: list[tuple[World, Verdict]]
    nominal: Verdict
    """Result of the fold on the fine mesh, in the world in which every disturbance has its mean."""
    difference: np.ndarray
    """Marks on the fine mesh minus marks on the mesh of the draws [m], shape (m,).

    Marks are the m lengths that are measured after a fold. For this difference, every disturbance has its mean."""
    simulated: int
    """Number of simulations that ran now, because their results had not been saved before."""


def draw(
    learned: Result,
    disturbances: Disturbances,
    out: Path | None,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Draws:
    """Simulate a fold in disturbed worlds. Simulations that were saved are not repeated.

    Args:
        learned: The fold.
        disturbances: Disturbances of the set-up before any fold was observed.
        out: Folder in which simulations are saved; None if they are not saved.
        executor: Executor of the simulations. None for threads on all processors, if the simulator supports threads.
        progress: Function that is called after every simulation.
    """
    task = replace(learned.task, reach=None)
    fine = FoldOnMesh(Nominal(task), learned.best.parameters)
    coarse = coarser_fold(fine) or fine
    centre = mean_world(disturbances)
    worlds = [centre, *sample(disturbances)]
    wanted = [(fine, centre), *((coarse, world) for world in worlds)]
    cache = VerdictCache(None if out is None else out / KEPT)
    names = {id(mesh): mesh.key for mesh in (fine, coarse)}
    keys = [cache.key(names[id(mesh)], world) for mesh, world in wanted]
    missing = {
        key: (mesh, world) for key, (mesh, world) in zip(keys, wanted, strict=True) if not _is_complete(cache.get(key))
    }
    threads = processors() if capabilities(task.simulator).parallel else 1
    if missing:
        with executor_of(executor, threads) as workers:
            simulate_missing(missing, workers, cache, lambda left: progress(len(missing) - left, len(missing)))
    verdicts = [verdict for key in keys if (verdict := cache.get(key)) is not None]
    return Draws(
        coarse,
        list(zip(worlds, verdicts[1:], strict=True)),
        verdicts[0],
        _difference(verdicts[0], verdicts[1]),
        len(missing),
    )


def sample(disturbances: Disturbances) -> list[World]:
    """Return the worlds (values of all disturbances) of the draws with the given and with the wider deviations."""
    usual = sample_worlds(disturbances, USUAL, 0, Stream.MARGINS)
    wide = sample_worlds(disturbances, WIDE, 0, Stream.OBSERVATION)
    centre = mean_world(disturbances)
    return [*usual, *(widened(world, centre) for world in wide)]


def widened(world: World, centre: World) -> World:
    """Return a world whose disturbances are `WIDER` times as far from their means as in `world`."""
    return World({name: centre[name] + WIDER * (value - centre[name]) for name, value in world.values.items()})


def _is_complete(verdict: Verdict | None) -> bool:
    """Return whether a verdict (the result of a fold) needs no new simulation.

    It needs none if it has its marks, or if its simulation failed. Verdicts of older versions lack marks.
    """
    return verdict is not None and (verdict.marks is not None or verdict.mean_vertex_distance is None)


def _difference(fine: Verdict, coarse: Verdict) -> np.ndarray:
    if fine.marks is None or coarse.marks is None:
        return np.zeros(len(MARKS))
    return np.array([fine.marks[name] - coarse.marks[name] for name in MARKS])
