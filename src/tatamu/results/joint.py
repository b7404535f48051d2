"""How sure a fold is: the record of many draws in which everything was off at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tatamu.disturbances import Limits, Verdict, share_of
from tatamu.folding.score import vertex_distances
from tatamu.folding.task import Task
from tatamu.results.margins import JointMargin, Spread


def joint_margin(
    task: Task, verdicts: Sequence[Verdict], limits: Limits, distances: Sequence[float] | None = None
) -> JointMargin:
    """The share of worlds in which a fold holds, and how far from its target it ends.

    Args:
        task: The fold.
        verdicts: Of the worlds.
        limits: What the fold must keep in order to hold.
        distances: Mean vertex distances, where they are known better than the verdicts say [m].
    """
    share = share_of(verdicts, limits)
    if distances is None:
        distances = [distance(task, verdict) for verdict in verdicts]
    median, q90 = np.quantile(distances, [0.5, 0.9])
    return JointMargin(
        draws=share.draws,
        held=share.held,
        share=share.share,
        interval=share.interval,
        mean_vertex_distance=Spread(median=float(median), q90=float(q90), worst=float(max(distances))),
    )


def distance(task: Task, verdict: Verdict) -> float:
    """Mean vertex distance in a world [m]; twice that of untouched cloth where the simulation failed."""
    if verdict.mean_vertex_distance is not None:
        return verdict.mean_vertex_distance
    return 2.0 * float(vertex_distances(task.fold.target, task.fold.start).mean())
