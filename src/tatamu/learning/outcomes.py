"""Records of a study: trials, baselines, and the result that they make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from optuna.distributions import FloatDistribution, IntDistribution
from optuna.trial import FrozenTrial

from tatamu import __version__
from tatamu.crossings import crossings_over_time
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import Score
from tatamu.folding.task import Asked, Outcome
from tatamu.learning.evaluation import Evaluation
from tatamu.learning.study import Identity
from tatamu.results import Baseline, Crossings, JointMargin, Result, Trial
from tatamu.rollout import Rollout

MEASURES = tuple(name for name in Score.__dataclass_fields__ if name != "objective")


def attributes_of(outcome: Outcome, trajectory_length: float, seconds: float, **more: Any) -> dict[str, Any]:
    """The attributes of a trial that are kept beside its parameters and its objective.

    Args:
        outcome: Of the trial.
        trajectory_length: l_x [m].
        seconds: How long it took [s].
        more: Further attributes, unless they are None; most are fields of a trial in `result.json`.
    """
    measures = outcome.score.as_dict() if outcome.score else dict.fromkeys(MEASURES)
    return {
        "state": "failed" if outcome.failed else "complete",
        "error": outcome.error,
        **{name: measures[name] for name in MEASURES},
        "trajectory_length": trajectory_length,
        "seconds": round(seconds, 3),
        **{name: value for name, value in more.items() if value is not None},
    }


def trial_of(trial: FrozenTrial) -> Trial:
    """A finished trial of the study."""
    return Trial(**{"number": trial.number, "parameters": trial.params, "objective": trial.value, **trial.user_attrs})


def best_number(trials: Sequence[FrozenTrial], count: int | None = None, coarse: float | None = None) -> int | None:
    """Number of the complete trial of least objective among the first `count`; None if all failed.

    Args:
        trials: Finished trials in order.
        count: How many of them count; None: all.
        coarse: Spacing of the coarser mesh [m]: its trials count only where no other is complete. None: there is none.
    """
    complete = [t for t in trials[:count] if t.user_attrs["state"] == "complete"]
    fine = [t for t in complete if coarse is None or t.user_attrs.get("spacing") != coarse]
    return min(fine or complete, key=lambda t: (t.value, t.number)).number if complete else None


def baseline_of(name: str, manipulation: Manipulation, evaluation: Evaluation) -> Baseline:
    """The record of a fixed trajectory, by its name."""
    title, _ = BASELINES[name]
    outcome = evaluation.outcome
    attributes = attributes_of(outcome, manipulation.trajectory_length, evaluation.seconds)
    path = manipulation.paths[0][:: max(1, len(manipulation.paths[0]) // 100)]
    return Baseline(name=name, title=title, objective=outcome.objective, path=path, **attributes)


def crossings_of(rollout: Rollout) -> Crossings:
    """How many edges pass through triangles: at the end, and in the worst frame."""
    counts = crossings_over_time(rollout.positions, rollout.faces)
    return Crossings(final=int(counts[-1]), most=int(counts.max()))


def result_of(
    identity: Identity,
    asked: Asked | None,
    trials: Sequence[FrozenTrial],
    baselines: Sequence[Baseline] | None,
    best: int | None,
    outcome: Outcome | None,
    judged: JointMargin | None = None,
) -> Result:
    """The result of a study.

    Args:
        identity: The task and the search.
        asked: What the task was made from.
        trials: The finished trials in order.
        baselines: The fixed trajectories, if they were scored.
        best: Number of the best trial; None if all failed.
        outcome: Of the best trial.
        judged: How sure its fold is, where that was asked.
    """
    records = [trial_of(trial) for trial in trials]
    return Result(
        version=1,
        tatamu=__version__,
        task=identity.task,
        sampler=identity.sampler,
        grasps=identity.grasps,
        seed=identity.seed,
        parallel=identity.parallel,
        first=identity.first,
        coarse=identity.coarse,
        bounds=_bounds(trials[0]),
        disturbances=identity.disturbances,
        worlds=identity.worlds,
        quantile=identity.quantile,
        judged=judged,
        asked=asked,
        wall_seconds=round(sum(record.seconds or 0.0 for record in records), 3),
        best=best,
        crossings=crossings_of(outcome.rollout) if outcome and outcome.rollout else None,
        trials=records,
        baselines=list(baselines or []),
    )


def _bounds(trial: FrozenTrial) -> dict[str, list[float]]:
    """Least and greatest value of each parameter that the search could choose."""
    numbers = (FloatDistribution, IntDistribution)
    return {name: [each.low, each.high] for name, each in trial.distributions.items() if isinstance(each, numbers)}
