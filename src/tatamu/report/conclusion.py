"""Writes the conclusion of a study: whether the fold succeeds, notes on the search, and advice if the fold failed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from tatamu.folding.score import Limits, Measured
from tatamu.report.measures import OVERLAP, SUCCESS, grade
from tatamu.study.record import PlanRecord, ResultRecord

MEANING = {
    "x1": "P1 ahead of the grasp",
    "z1": "P1 above the grasp",
    "x2": "P2 ahead of the grasp",
    "z2": "P2 above the grasp",
    "g1": "left grasp, from the corner inwards",
    "g2": "right grasp, from the corner inwards",
}
"""Meaning of each parameter of a fold, Eq. (9), in a few words. P1 and P2 are the inner control points of a hand's
path, a Bézier curve."""


@dataclass(frozen=True)
class Conclusion:
    """The judgement of a fold, or of a plan of several folds: whether it succeeded, and why."""

    succeeded: bool
    measures: list[str]
    """Values that decide whether the fold succeeded, each as text."""
    notes: list[str] = field(default_factory=list)
    """Further lines of text about the fold and the search."""
    advice: list[str] = field(default_factory=list)
    """Advice on what to do; empty if the fold succeeded."""
    steps: list[tuple[str, Conclusion]] = field(default_factory=list)
    """Name and conclusion of each step of a plan; empty for a single fold."""

    @property
    def text(self) -> str:
        """One line that states success or failure, and the values that decide between them."""
        return f"{'succeeded' if self.succeeded else 'failed'}: {', '.join(self.measures)}"


def of_fold(result: ResultRecord) -> Conclusion:
    """Return the conclusion (success or failure, and why) for a single fold, or for a step of a plan."""
    best = result.best_score
    succeeded = best.succeeds
    return Conclusion(
        succeeded,
        _measures(best, succeeded, "from the target"),
        notes=[*_origin(result), *on_bounds(result)],
        advice=[] if succeeded else _about_search(result),
    )


def of_plan(plan: PlanRecord, results: Sequence[ResultRecord]) -> Conclusion:
    """Return the conclusion (success or failure, and why) for a plan of several steps.

    Args:
        plan: Record of the plan.
        results: Records of the studies of all steps.
    """
    steps = [of_fold(result) for result in results]
    names = [f"step {n}, {step.title or 'fold'}" for n, step in enumerate(plan.steps, start=1)]
    succeeded = Limits().hold(plan.final)
    return Conclusion(
        succeeded,
        _measures(plan.final, succeeded, "from the target of the whole plan"),
        notes=[f"{name}: {note}" for name, step in zip(names, steps, strict=True) for note in step.notes],
        advice=[] if succeeded else _about_steps(plan, steps, names),
        steps=list(zip(names, steps, strict=True)),
    )


def _origin(result: ResultRecord) -> list[str]:
    """Return a note on the origin of the best fold: found by the search, or one of the curves given to the search.

    The search starts with some given curves. The note compares the best of them with the best fold. Curves are only
    compared if they ran on the same mesh as the best trial. Without such curves, there is no note.
    """
    best = result.best_trial
    if result.best_is_initial:
        return [f"trial {best.number}, the best of {len(result.trials)}, is one of the hand-designed curves"]
    curve = result.best_initial
    if curve is None:
        return []
    return [
        f"trial {best.number} was found by the search; its path is {best.trajectory_length or 0.0:.3f} m long, and the "
        f"best hand-designed curve, trial {curve.number}, is {curve.trajectory_length or 0.0:.3f} m long"
    ]


def on_bounds(result: ResultRecord) -> list[str]:
    """Return a note on parameters of the best trial that are on a bound of the search.

    Grasps at the corner of the cloth are not reported.
    """
    if result.best_is_initial:  # curves that were given to the search may lie on its bounds on purpose
        return []
    chosen = result.best_trial.parameters
    found = []
    for name, (low, high) in result.bounds.items():
        if name == "g2" and result.task.hands == 1:
            continue
        whole = name.startswith("g")
        value = float(int(chosen[name])) if whole else float(chosen[name])
        last = (result.task.candidates or 0) - 1 if whole else high
        near = 0.01 * (high - low)  # up to this distance, the parameter counts as being on the bound
        if value > last - near or (not whole and value < low + near):
            place = f"the last of 0 to {last:g}" if whole else f"in a range of {low:g} to {high:.3g} m"
            shown = f"{value:.0f}, {place}" if whole else f"{value:.3g} m, {place}"
            found.append(f"{MEANING.get(name, name)} ({name}): {shown}")
    if not found:
        return []
    return [
        "the best trial is at a limit of the search, so there may be a better fold beyond this limit: "
        + "; ".join(found)
    ]


def _measures(measured: Measured, succeeded: bool, apart: str) -> list[str]:
    distance = measured.mean_vertex_distance or 0.0
    graded = f"{grade(distance)}; " if succeeded else ""  # a fold near its target may still fail
    moving = measured.moving_vertex_distance
    part = "" if moving is None else f", {1e3 * moving:.1f} mm in the part that moves"
    return [
        f"{1e3 * distance:.1f} mm {apart} on average{part} ({graded}success below {1e3 * SUCCESS:g} mm)",
        f"mask IoU {measured.mask_iou or 0.0:.3f} (success from {OVERLAP:.2f})",
    ]


def _about_search(result: ResultRecord) -> list[str]:
    """Return advice to the user after a search without a successful fold, based on the trials of the search."""
    trials = result.trials
    best = result.best_trial
    failed = [trial for trial in trials if trial.state == "failed"]
    lines = []
    if 2 * len(failed) > len(trials):
        lines.append(f"{len(failed)} of {len(trials)} trials failed; last error: {failed[-1].error}")
    other = next((trial for trial in trials if trial.score is not None and trial.score.succeeds), None)
    if other is not None and other.score is not None:
        help_by = "learn with disturbances (the default), so that only a fold that succeeds can be the best"
        if result.disturbances is not None:
            help_by = "try a finer mesh (--spacing)"
        distance = 1e3 * other.score.mean_vertex_distance
        lines.append(
            f"trial {other.number} succeeds ({distance:.1f} mm from the target), but the search preferred a shorter "
            f"path; {help_by}"
        )
    lines += [
        f"the fixed trajectory {each.label!r} succeeds, {1e3 * each.score.mean_vertex_distance:.1f} mm from the target"
        for each in result.baselines
        if each.score is not None and each.score.succeeds
    ][:1]
    more = f"more trials: repeat the command with --trials {2 * len(trials)}"
    place = f"trial {best.number} of {len(trials)}"
    if best.number >= 0.6 * len(trials):  # the search was probably still improving
        return [*lines, f"{more}; the best trial came late, {place}, so more trials are likely to help"]
    other_fold = "another fold or other grasps: `tatamu plans` draws the folds in which hands lift the whole garment"
    return [*lines, f"{more}; the best trial came early, {place}, so more trials may not help", other_fold]


def _about_steps(plan: PlanRecord, steps: Sequence[Conclusion], names: Sequence[str]) -> list[str]:
    """Return advice on which step of a plan to improve."""
    failing = [number for number, step in enumerate(steps) if not step.succeeded]
    if failing:
        first = failing[0]  # a later step starts from the result of this step
        page = f"{plan.steps[first].folder}/report.html"
        return [f"look at {names[first]}, the first to fail by itself: {page}", *steps[first].advice]
    away = [step.whole.mean_vertex_distance for step in plan.steps]
    growth = [later - before for before, later in zip([0.0, *away], away, strict=False)]
    most = max(range(len(growth)), key=growth.__getitem__)
    return [
        f"every step succeeds by itself, but errors add up, most in {names[most]} (+{1e3 * growth[most]:.1f} mm): "
        f"{plan.steps[most].folder}/report.html",
        f"more trials: repeat the command with --trials {2 * max(step.trials for step in plan.steps)}",
    ]
