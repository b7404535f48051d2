"""Collects the contents of the tables on a fold's page: measures, parameters, grasps, timing and material."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.folding.score import Score
from tatamu.report.measures import grade
from tatamu.show.material import properties
from tatamu.study.result import Result

Facts = list[tuple[str, str]]
"""Rows of a table: pairs of a name and a value, both as plain text."""


@dataclass(frozen=True)
class Column:
    """One fold in a table that compares several folds, in which it has its own column."""

    name: str
    score: Score | None
    """Score of the fold; None if it failed."""

    @property
    def verdict(self) -> str:
        """Grade of the fold, which depends on its mean vertex distance."""
        return grade(None if self.score is None else self.score.mean_vertex_distance)


def measures(fold: Result) -> list[Column]:
    """Return the folds that the page's table of measures compares.

    They are the learned fold and the fixed trajectories. If another trial has the lowest objective C, that trial is
    included as well.
    """
    minimum = fold.record.minimum_objective
    other = [] if minimum is None or minimum.number == fold.record.best else [Column("minimum C", minimum.score)]
    fixed = [Column(each.label, each.score) for each in fold.record.baselines]
    return [Column("learned", fold.best.score), *other, *fixed]


def parameters(fold: Result) -> Facts:
    """Return the parameters that the search chose for the fold, Eq. (9)."""
    given = fold.record.best_trial.parameters
    lengths = [
        (f"{name[0]}{'₁₂'[int(name[1]) - 1]} of P{'₁₂'[int(name[1]) - 1]}", f"{1e3 * given[name]:.1f} mm")
        for name in ("x1", "z1", "x2", "z2")
        if name in given
    ]
    count = fold.record.task.candidates
    of = f" of {count}" if count else ""
    # The paper searches the grasps g1 and g2 as continuous numbers, and rounds these numbers down.
    grasps = [
        (f"g{'₁₂'[k]}, {hand} grasp", f"{int(given[name])}{of}")
        for k, (name, hand) in enumerate((("g1", "left"), ("g2", "right")))
        if name in given
    ]
    return [*lengths, *grasps]


def control_points(fold: Result) -> list[tuple[str, str, list[str]]]:
    """Return the name, the grasp and the control points [mm] of each hand."""
    return [
        (
            arm.name,
            f"vertex {arm.grasp.vertex}" + (f", holds {len(arm.grasp.patch)}" if arm.grasp.patch else ""),
            [_place(point) for point in arm.control_points],
        )
        for arm in fold.arms
    ]


def _place(point: np.ndarray) -> str:
    return ", ".join(f"{1e3 * value:.0f}".replace("-", "−") for value in point)


def timing(fold: Result) -> Facts:
    """Return the times of the fold at which the hands close, start to move, arrive and open."""
    known = {
        "closes": "hands close",
        "starts": "hands start",
        "arrives": "hands arrive",
        "opens": "hands open",
        "ends": "rollout ends",
        "top_speed": "top speed",
    }
    given = fold.description.timing_values
    return [
        (word, f"{given[name]:.3g} {'m/s' if name == 'top_speed' else 's'}")
        for name, word in known.items()
        if name in given
    ]


def material(fold: Result) -> Facts:
    """Return the properties of the cloth's material, with units."""
    return [(each.name, str(each)) for each in properties(fold.record.task.material)]


def task(fold: Result) -> Facts:
    """Return facts about the task, about its simulation and about its search."""
    chosen = fold.record.task
    info = fold.rollout.info
    result = fold.record
    size = " × ".join(f"{side:g}" for side in chosen.size) + " m" if chosen.size else ""
    simulated = info.get("wall_seconds")
    pairs = [
        ("garment", chosen.garment),
        ("size", size),
        ("fold", chosen.fold),
        ("vertices", str(len(fold.start))),
        ("spacing", f"{1e3 * chosen.spacing:.3g} mm" if chosen.spacing else ""),
        ("simulator", f"{chosen.simulator} {info.get('version', '')}".strip()),
        ("one rollout", f"{simulated:.2f} s" if isinstance(simulated, int | float) else ""),
        ("sampler, seed", f"{result.sampler}, {result.seed}"),
        ("trials", f"{len(result.trials)}, best no. {result.best}"),
        ("whole search", f"{result.wall_seconds:.3g} s" if result.wall_seconds is not None else ""),
    ]
    return [pair for pair in pairs if pair[1]]


def warnings(fold: Result) -> list[str]:
    """Return the warnings that the simulator gave when it simulated the fold."""
    return [str(warning) for warning in fold.rollout.info.get("warnings") or []]
