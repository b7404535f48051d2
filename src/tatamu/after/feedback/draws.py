"""The simulated scenarios with which measured folds are compared. `tatamu margins` shares them, by a common file."""

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

SCENARIOS = 100
"""Number of scenarios: the first draws of `tatamu margins`."""

Progress = Callable[[int, int], None]
"""Callback with the numbers of finished simulations and of all simulations."""


@dataclass(frozen=True)
class Draws:
    """Scenarios, and how the fold ended in them."""

    mesh: FoldOnMesh
    """The fold on the mesh that was simulated."""
    worlds: list[tuple[World, Verdict]]
    nominal: Verdict
    """Result on the fine mesh if every disturbance has its mean."""
    difference: np.ndarray
    """Marks on the fine mesh minus marks on the mesh of the scenarios [m], shape (m,)."""
    simulated: int
    """Number of simulations that ran now."""


def draw(
    learned: Result,
    disturbances: Disturbances,
    out: Path | None,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Draws:
    """Simulate a fold in scenarios. Those in the folder `out` are not repeated, and new ones are saved there."""
    task = replace(learned.task, reach=None)
    fine = FoldOnMesh(Nominal(task), learned.best.parameters)
    coarse = coarser_fold(fine) or fine
    centre = mean_world(disturbances)
    worlds = [centre, *sample_worlds(disturbances, SCENARIOS, 0, Stream.MARGINS)]
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


def _is_complete(verdict: Verdict | None) -> bool:
    """Return whether a verdict has its marks, unless the simulation failed. Those of older versions lack them."""
    return verdict is not None and (verdict.marks is not None or verdict.mean_vertex_distance is None)


def _difference(fine: Verdict, coarse: Verdict) -> np.ndarray:
    if fine.marks is None or coarse.marks is None:
        return np.zeros(len(MARKS))
    return np.array([fine.marks[name] - coarse.marks[name] for name in MARKS])
