"""The trials of one study: proposed in order, evaluated anywhere, recorded in order; then its folder."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from tatamu.errors import TatamuError
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation, scene_of
from tatamu.folding.score import vertex_distances
from tatamu.folding.task import Outcome, Task
from tatamu.learning.evaluation import Evaluation, ended, submitted
from tatamu.learning.outcomes import attributes_of, baseline_of, best_number, result_of
from tatamu.learning.study import OptunaStudy
from tatamu.results import MOMENTS, ResultFolder, describe_manipulation
from tatamu.results.result import Parameters

Stage = Literal["trials", "baselines", "report"]
"""Stages of a study: its trials, then the fixed trajectories, then its files and the page."""


@dataclass(frozen=True)
class Progress:
    """Progress of a study; given to the caller after every trial and when a stage begins."""

    done: int
    trials: int
    best: float | None
    """Least objective so far."""
    best_distance: float | None
    """Mean vertex distance of that trial [m]."""
    stage: Stage = "trials"


@dataclass(frozen=True)
class Pending:
    """A manipulation that is being evaluated."""

    manipulation: Manipulation
    evaluation: Future[Evaluation]


class Runner:
    """Trials of one study; the outcomes that the folder keeps are remembered, others are forgotten."""

    def __init__(self, task: Task, study: OptunaStudy, executor: Executor) -> None:
        """Make a runner, and ask the task's robot again what it was asked before: it may have learned from it."""
        self.task = task
        self.study = study
        self._executor = executor
        self._kept: dict[int, Outcome] = {}
        for trial in study.trials:
            task.refused(task.manipulation(trial.params))

    def run(self, trials: int, baselines: bool) -> Iterator[Stage]:
        """Run trials until there are `trials` of them, and the fixed trajectories.

        Yields the stage after each trial, in order, and once more when only the fixed trajectories are left.

        Args:
            trials: How many there shall be in the end.
            baselines: Also score the fixed trajectories, if they were not before.
        """
        running: deque[tuple[Parameters, Pending]] = deque()
        others: dict[str, Pending] = {}
        pending = self.study.identity.parallel
        try:
            for number in range(len(self.study.trials), trials):
                if len(running) == pending:
                    self._finish(*running.popleft())
                    yield "trials"
                parameters = self.study.ask([p for p, _ in running], max(0, number - pending + 1))
                running.append((parameters, self._begin(self.task.manipulation(parameters), self._best())))
            if baselines and self.study.baselines is None:
                others |= {name: self._begin(make(self.task.fold), -np.inf) for name, (_, make) in BASELINES.items()}
            while running:
                self._finish(*running.popleft())
                yield "trials"
            if others:
                yield "baselines"
                self.study.baselines = [
                    baseline_of(name, each.manipulation, self._ended(each, f"baseline {name}"))
                    for name, each in others.items()
                ]
        finally:
            for each in [*(begun for _, begun in running), *others.values()]:
                each.evaluation.cancel()  # of a run that was interrupted; what has ended stays ended

    def _begin(self, manipulation: Manipulation, below: float = np.inf) -> Pending:
        return Pending(manipulation, submitted(self._executor, self.task, manipulation, below))

    def _ended(self, begun: Pending, which: str) -> Evaluation:
        return ended(self.task, begun.manipulation, begun.evaluation, f"seed {self.study.identity.seed}, {which}")

    def _best(self) -> float:
        """The least objective so far: only a trial with less may be kept. Infinite where all errors are wanted."""
        if self.study.wants_errors:
            return np.inf
        trials = self.study.trials
        best = best_number(trials)
        return np.inf if best is None else float(trials[best].values[0])

    def _finish(self, parameters: Parameters, begun: Pending) -> None:
        """Record a trial when it has ended."""
        evaluation = self._ended(begun, f"trial {len(self.study.trials)}")
        outcome = evaluation.outcome
        attributes = attributes_of(outcome, begun.manipulation.trajectory_length, evaluation.seconds)
        errors = None if outcome.failed or not self.study.wants_errors else self._errors_of(outcome)
        self.study.tell(parameters, outcome.objective, attributes, errors)
        trials = self.study.trials
        self._kept[len(trials) - 1] = outcome
        needed = {*self._shown().values(), best_number(trials)}
        self._kept = {number: kept for number, kept in self._kept.items() if number in needed}

    @property
    def succeeded(self) -> bool:
        """Whether any trial so far is complete."""
        return best_number(self.study.trials) is not None

    def progress(self, trials: int, stage: Stage = "trials") -> Progress:
        """How far the study is."""
        done = self.study.trials
        best = best_number(done)
        return Progress(
            done=len(done),
            trials=trials,
            best=None if best is None else done[best].value,
            best_distance=None if best is None else done[best].user_attrs["mean_vertex_distance"],
            stage=stage,
        )

    def write(self, folder: ResultFolder) -> Path:
        """Write the folder and its report."""
        from tatamu.report import write_report

        trials = self.study.trials
        best = best_number(trials)
        outcome = None if best is None else self._outcome(best)
        folder.write_result(result_of(self.study.identity, self.task.asked, trials, self.study.baselines, outcome))
        if best is None or outcome is None:
            raise TatamuError(
                f"{folder.path}: all {len(trials)} trials failed; the last said: {trials[-1].user_attrs['error']}"
            )
        assert outcome.rollout is not None, "the best trial is complete"
        fold = self.task.fold
        manipulation = self.task.manipulation(trials[best].params)
        folder.write_best(
            describe_manipulation(fold, manipulation),
            scene_of(fold, manipulation),
            outcome.rollout,
            fold.target,
            {name: self._errors(number) for name, number in self._shown().items()},
        )
        return write_report(folder.path)

    def _shown(self) -> dict[str, int]:
        """Trials whose errors the folder keeps: the best of those that `MOMENTS` names."""
        trials = self.study.trials
        counts = {name: count for name, (count, _) in MOMENTS.items() if count <= len(trials)}
        numbers = {name: best_number(trials, count) for name, count in counts.items()}
        return {name: number for name, number in numbers.items() if number is not None}

    def _errors(self, number: int) -> np.ndarray:
        """e_i of a complete trial [m], shape (n,)."""
        return self._errors_of(self._outcome(number))

    def _errors_of(self, outcome: Outcome) -> np.ndarray:
        """e_i of Eq. (12) of an outcome that is complete [m], shape (n,)."""
        assert outcome.rollout is not None, "the trial is complete"
        return vertex_distances(self.task.fold.target, outcome.rollout.positions[-1])

    def _outcome(self, number: int) -> Outcome:
        """The outcome of a finished trial, simulated again if it was before this run; the same to the last bit."""
        if number not in self._kept:
            manipulation = self.task.manipulation(self.study.trials[number].params)
            self._kept[number] = self._ended(self._begin(manipulation), f"trial {number}").outcome
        return self._kept[number]
