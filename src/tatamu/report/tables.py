"""Collects the contents of the tables on a fold's page: measures, parameters, grasps, timing and material."""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.folding.score import Score
from tatamu.report.measures import grade
from tatamu.show.material import properties
from tatamu.show.quantity import number
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
    small = {"1": "₁", "2": "₂"}
    lengths = [
        (f"{axis}{small[n]} of P{small[n]}", f"{1e3 * given[axis + n]:.1f} mm")
        for axis, n in ("x1", "z1", "x2", "z2")
        if axis + n in given
    ]
    count = fold.record.task.candidates
    of = f" of {count}" if count else ""
    # The paper searches the grasps g1 and g2 as continuous numbers, and rounds these numbers down.
    hands = {"g1": "left", "g2": "right"}
    grasps = [(f"g{small[g[1]]}, {hands[g]} grasp", f"{int(given[g])}{of}") for g in hands if g in given]
    return [*lengths, *grasps]


def control_points(fold: Result) -> list[tuple[str, str, list[str]]]:
    """Return the name, the grasp and the control points [mm] of each hand."""
    rows: list[tuple[str, str, list[str]]] = []
    for arm in fold.arms:
        grasp = f"vertex {arm.grasp.vertex}" + (f", holds {len(arm.grasp.patch)}" if arm.grasp.patch else "")
        places = [", ".join(number(value, "mm", ".0f") for value in point) for point in arm.control_points]
        rows.append((arm.name, grasp, places))
    return rows


def timing(fold: Result) -> Facts:
    """Return the times of the fold at which the hands close, start to move, arrive and open."""
    known = {"closes": "hands close", "starts": "hands start", "arrives": "hands arrive", "opens": "hands open"}
    known |= {"ends": "rollout ends", "top_speed": "top speed"}
    given = fold.description.timing_values
    units = {"top_speed": "m/s"}
    return [(word, f"{given[name]:.3g} {units.get(name, 's')}") for name, word in known.items() if name in given]


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
