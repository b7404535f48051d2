"""How sure a fold is: the record of many draws in which everything was off at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tatamu.disturbances import Judged, Limits, Verdict, on_own_mesh, share_of
from tatamu.folding.score import vertex_distances
from tatamu.folding.task import Task
from tatamu.results.margins import JointMargin, Spread


def joint_margin(task: Task, judged: Sequence[Judged], limits: Limits) -> JointMargin:
    """The share of worlds in which a fold holds, and how far from its target it ends.

    Args:
        task: The fold, on its own mesh.
        judged: Of the worlds.
        limits: What the fold must keep in order to hold.
    """
    share = share_of([one.verdict for one in judged], limits)
    distances = distances_of(task, judged, limits)
    median, q90 = np.quantile(distances, [0.5, 0.9])
    return JointMargin(
        draws=share.draws,
        held=share.held,
        share=share.share,
        interval=share.interval,
        mean_vertex_distance=Spread(median=float(median), q90=float(q90), worst=float(max(distances))),
    )


def distances_of(task: Task, judged: Sequence[Judged], limits: Limits) -> list[float]:
    """Mean vertex distances on a fold's own mesh [m]; of what ran on the coarse one alone, what pairs of both say."""
    predicted = on_own_mesh(judged, limits)
    distances = []
    for one in judged:
        found = _distance(task, one.verdict)
        foreign = not one.own and one.verdict.error is None
        distances.append(predicted(found) if foreign else found)
    return distances


def _distance(task: Task, verdict: Verdict) -> float:
    """Mean vertex distance in a world [m]; twice that of untouched cloth where the simulation failed."""
    if verdict.mean_vertex_distance is not None:
        return verdict.mean_vertex_distance
    return 2.0 * float(vertex_distances(task.fold.target, task.fold.start).mean())
