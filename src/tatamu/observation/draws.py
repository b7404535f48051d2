"""Simulated draws with which observations are compared: the draws of `tatamu margins`, and wider draws.

A draw is one world: one random value of each disturbance. `tatamu margins` and `tatamu observe` keep simulations in the
same file, so neither repeats a world that the other has simulated.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tatamu.disturbances import Disturbances, Stream, World, mean_world, sample_worlds
from tatamu.evaluation import Nominal
from tatamu.folding.marks import MARKS
from tatamu.margins.measurement import KEPT, coarser_fold
from tatamu.robustness import FoldOnMesh, Verdict, VerdictCache, simulate_missing
from tatamu.simulators import capabilities
from tatamu.simulators.many import executor_of, processors
from tatamu.study import Result

USUAL = 100
"""Number of draws from the stated disturbances; they are the first draws of `tatamu margins`."""
WIDE = 100
"""Number of draws that are twice as wide, so that they also cover a set-up with larger errors than stated."""
WIDER = 2.0
"""Ratio of the deviations of the wider draws to the stated ones."""

Progress = Callable[[int, int], None]
"""Callback with the number of finished simulations, and their total."""


@dataclass(frozen=True)
class Draws:
    """Worlds, and how a fold ended in them."""

    mesh: FoldOnMesh
    """The fold on the mesh of the draws."""
    worlds: list[tuple[World, Verdict]]
    nominal: Verdict
    """Verdict in the world of the means, on the fine mesh."""
    difference: np.ndarray
    """Marks in the world of the means: those on the fine mesh minus those on the mesh of the draws [m], shape (m,)."""
    simulated: int
    """Number of new simulations."""


def draw(
    learned: Result,
    disturbances: Disturbances,
    out: Path | None,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Draws:
    """Simulate a fold in disturbed worlds; kept simulations are not repeated.

    Args:
        learned: The fold.
        disturbances: Disturbances of the set-up before anything was observed.
        out: Folder that keeps simulations; None to keep none.
        executor: Executor of the simulations; None for threads on every processor, if the simulator can.
        progress: Called after every simulation.
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
    """Return the worlds of the draws."""
    usual = sample_worlds(disturbances, USUAL, 0, Stream.MARGINS)
    wide = sample_worlds(disturbances, WIDE, 0, Stream.OBSERVATION)
    centre = mean_world(disturbances)
    return [*usual, *(widened(world, centre) for world in wide)]


def widened(world: World, centre: World) -> World:
    """Return a world `WIDER` times as far from the means."""
    return World({name: centre[name] + WIDER * (value - centre[name]) for name, value in world.values.items()})


def _is_complete(verdict: Verdict | None) -> bool:
    """Return whether a verdict has its marks, or cannot have any. Verdicts of older versions lack marks."""
    return verdict is not None and (verdict.marks is not None or verdict.mean_vertex_distance is None)


def _difference(fine: Verdict, coarse: Verdict) -> np.ndarray:
    if fine.marks is None or coarse.marks is None:
        return np.zeros(len(MARKS))
    return np.array([fine.marks[name] - coarse.marks[name] for name in MARKS])
