"""The trials of one study: proposed in order, evaluated anywhere, recorded in order; then its folder."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from optuna.trial import FrozenTrial

from tatamu.disturbances import Asker, FoldOnMesh, Limits, Memory, Stream, drawn, fold_on_coarser_mesh, settled
from tatamu.errors import TatamuError
from tatamu.folding.baselines import BASELINES
from tatamu.folding.interpolation import interpolated
from tatamu.folding.manipulation import scene_of
from tatamu.folding.score import vertex_distances
from tatamu.folding.task import Outcome, Task
from tatamu.learning.evaluation import Evaluation, Pending, submitted
from tatamu.learning.expectation import Added, Demand, Expectation, Standing
from tatamu.learning.outcomes import attributes_of, baseline_of, best_number, result_of
from tatamu.learning.schedule import Schedule, ScheduledTrial
from tatamu.learning.study import OptunaStudy, ProposedTrial
from tatamu.results import MOMENTS, JointMargin, ResultFolder, describe_manipulation
from tatamu.results.joint import joint_margin
from tatamu.results.result import Parameters

Stage = Literal["trials", "baselines", "report"]
"""Stages of a study: its trials, then the fixed trajectories, then its files and the page."""


JUDGED = 48
"""Worlds in which the best fold is judged in the end."""


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
    disturbed: bool = False
    """Whether the objective is an expectation, or a quantile, over disturbed worlds; else it is C of Eq. (10)."""


class Runner:
    """Trials of one study; the outcomes that the folder keeps are remembered, others are forgotten."""

    def __init__(
        self, task: Task, study: OptunaStudy, executor: Executor, expectation: Expectation | None = None
    ) -> None:
        """Make a runner of the trials that the study does not have yet.

        Args:
            task: The fold.
            study: Its study.
            executor: Where trials run.
            expectation: What is not known, and is to be expected; None: the objective is C of Eq. (10).
        """
        self.task = task
        self.study = study
        self._executor = executor
        self._expectation = expectation
        self._worlds = expectation.drawn(study.identity.seed) if expectation else ()
        self._kept: dict[int, Outcome] = {}

    def is_over(self, schedule: Schedule) -> bool:
        """Whether no trial is left to run."""
        return schedule.coarse_next(self._planned([])) is None

    def run(self, schedule: Schedule, baselines: bool) -> Iterator[Stage]:
        """Run the trials that are left, and the fixed trajectories.

        Yields the stage after each trial, in order, and once more when only the fixed trajectories are left.

        Args:
            schedule: How many trials there shall be, and on which mesh.
            baselines: Also score the fixed trajectories, if they were not before.
        """
        self._remind_robot()
        running: deque[tuple[ProposedTrial, Pending]] = deque()
        others: dict[str, Pending] = {}
        pending = self.study.identity.parallel
        try:
            while (coarse := schedule.coarse_next(self._planned([each for each, _ in running]))) is not None:
                if len(running) == pending:
                    self._finish(*running.popleft())
                    yield "trials"
                known = max(0, len(self.study.trials) + len(running) - pending + 1)
                proposal = self.study.ask([each for each, _ in running], known, coarse)
                demand = self._demand(self.study.trials[:known], proposal)
                below = self._least(coarse, self.study.trials)
                beaten = self._least(False, self.study.trials[:known])
                running.append((proposal, self._begin(proposal.parameters, coarse, below, demand, beaten)))
            if baselines and self.study.baselines is None:
                made = {name: make(self.task.fold) for name, (_, make) in BASELINES.items()}
                others |= {name: submitted(self._executor, self.task, each, -np.inf) for name, each in made.items()}
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

    def _remind_robot(self) -> None:
        """Ask the task's robot again what this study asked it before a pause, and only that: it learns from it."""
        if self.task.reach is not None:
            self.task.reach.forget()
        for trial in self.study.trials:
            self.task.refused(self.task.manipulation(trial.params))

    def _planned(self, running: Sequence[ProposedTrial]) -> list[ScheduledTrial]:
        """The trials so far as a schedule sees them, those that are running at the end."""
        meshes = [self.study.is_coarse(trial) for trial in self.study.trials]
        gains = [trial.user_attrs.get("expected_gain") for trial in self.study.trials]
        finished = list(map(ScheduledTrial, meshes, gains))
        return finished + [ScheduledTrial(proposal.coarse, proposal.gain) for proposal in running]

    def _begin(
        self,
        parameters: Parameters,
        coarse: bool,
        below: float = np.inf,
        demand: Demand | None = None,
        beaten: float = np.inf,
    ) -> Pending:
        manipulation = self.task.manipulation(parameters)
        return submitted(
            self._executor, self.task, manipulation, below, parameters, coarse=coarse, demand=demand, beaten=beaten
        )

    def _demand(self, known: Sequence[FrozenTrial], proposal: ProposedTrial) -> Demand | None:
        """The worlds of the next trial, and the best that it has to beat: of its mesh, among the trials known."""
        if self._expectation is None:
            return None
        able = sorted(
            (trial for trial in known if trial.user_attrs.get("hardest")), key=lambda trial: (trial.value, trial.number)
        )
        here = [trial for trial in able if self.study.is_coarse(trial) == proposal.coarse]
        best = here[0] if here else None
        standing = Standing(float(best.values[0]), max(0.0, _added(best).objective)) if best else None
        hardest = self._expectation.hardest([_added(trial).hardest for trial in able])
        same = [trial for trial in able if self.study.is_coarse(trial) and trial.params == proposal.parameters]
        added = _added(same[0]) if same and not proposal.coarse else None
        return Demand(self._expectation, self._worlds, standing, hardest, added)

    def _ended(self, begun: Pending, which: str) -> Evaluation:
        return begun.ended(f"seed {self.study.identity.seed}, {which}")

    def _least(self, coarse: bool, trials: Sequence[FrozenTrial]) -> float:
        """The least objective of trials on one of the meshes: only a trial with a lesser one may be kept.

        Infinite where all errors are wanted.
        """
        if self.study.wants_errors:
            return np.inf
        here = [trial for trial in trials if self.study.is_coarse(trial) == coarse]
        return min((float(t.values[0]) for t in here if t.user_attrs["state"] == "complete"), default=np.inf)

    def _finish(self, proposal: ProposedTrial, begun: Pending) -> None:
        """Record a trial when it has ended."""
        evaluation = self._ended(begun, f"trial {len(self.study.trials)}")
        outcome = evaluation.outcome
        found = evaluation.expected
        attributes = attributes_of(
            outcome,
            begun.manipulation.trajectory_length,
            evaluation.seconds,
            spacing=self._spacing(proposal.coarse),
            ended="arrival" if evaluation.on_arrival else None,
            expected_gain=proposal.gain,
            objective=outcome.objective if found else None,
            worlds=found.worlds if found else None,
            expected_objective=found.objective if found else None,
            hardest=list(found.hardest) if found and found.hardest else None,
        )
        wanted = not outcome.failed and self.study.wants_errors
        errors = self._errors_of(outcome, proposal.coarse) if wanted else None
        self.study.tell(proposal.parameters, evaluation.objective, attributes, errors)
        self._kept[len(self.study.trials) - 1] = outcome
        needed = {*self._shown().values(), self._best()}
        self._kept = {number: kept for number, kept in self._kept.items() if number in needed}

    def _spacing(self, coarse: bool) -> float | None:
        """Of the mesh of a trial [m]; None in a study of one mesh."""
        held = self.study.identity.coarse
        return held if coarse or held is None else self.task.fold.garment.spacing

    def _best(self, count: int | None = None) -> int | None:
        return best_number(self.study.trials, count, self.study.identity.coarse)

    @property
    def succeeded(self) -> bool:
        """Whether any trial so far on the task's own mesh is complete."""
        best = self._best()
        return best is not None and not self.study.is_coarse(self.study.trials[best])

    def progress(self, trials: int, stage: Stage = "trials") -> Progress:
        """How far the study is."""
        done = self.study.trials
        best = self._best()
        return Progress(
            done=len(done),
            trials=trials,
            best=None if best is None else done[best].value,
            best_distance=None if best is None else done[best].user_attrs["mean_vertex_distance"],
            stage=stage,
            disturbed=self._expectation is not None,
        )

    def write(self, folder: ResultFolder, until_gain: float | None) -> Path:
        """Write the folder and its report.

        Args:
            folder: Where they go.
            until_gain: The expected gain at which the search ended by itself; None: it did not.
        """
        from tatamu.report import write_report

        trials = self.study.trials
        best = self._best()
        if not self.succeeded:
            best = None
        outcome = None if best is None else self._outcome(best)
        baselines = self.study.baselines
        judged = None if best is None else self._judged(trials[best].params)
        result = result_of(self.study.identity, self.task.asked, trials, baselines, best, outcome, judged)
        folder.write_result(result.model_copy(update={"until_gain": until_gain}))
        if best is None or outcome is None:
            own = [trial for trial in trials if not self.study.is_coarse(trial)]
            where = "" if len(own) == len(trials) else " on the garment's own mesh"
            failed = own or trials
            last = failed[-1].user_attrs["error"]
            raise TatamuError(f"{folder.path}: all {len(failed)} trials{where} failed; the last said: {last}")
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

    def _judged(self, parameters: Parameters) -> JointMargin | None:
        """How sure a fold is, in worlds in which it was not learned."""
        if self._expectation is None:
            return None
        manipulation = self.task.manipulation(parameters)
        own = FoldOnMesh(self.task.bare, manipulation)
        coarse = fold_on_coarser_mesh(self.task, manipulation, parameters)
        worlds = drawn(self._expectation.disturbances, JUDGED, self.study.identity.seed, Stream.JUDGING)
        asker = Asker(own, coarse, self._executor, Memory())
        return joint_margin(own.task, settled(asker, worlds, Limits()).judged, Limits())

    def _shown(self) -> dict[str, int]:
        """Trials whose errors the folder keeps: the best of those that `MOMENTS` names."""
        counts = {name: count for name, (count, _) in MOMENTS.items() if count <= len(self.study.trials)}
        numbers = {name: self._best(count) for name, count in counts.items()}
        return {name: number for name, number in numbers.items() if number is not None}

    def _errors(self, number: int) -> np.ndarray:
        """e_i of a complete trial, Eq. (12) [m], shape (n,)."""
        return self._errors_of(self._outcome(number), self.study.is_coarse(self.study.trials[number]))

    def _errors_of(self, outcome: Outcome, coarse: bool) -> np.ndarray:
        """e_i of a complete outcome, Eq. (12) [m], shape (n,); on the coarser mesh, in between its vertices."""
        assert outcome.rollout is not None, "the trial is complete"
        final = outcome.rollout.positions[-1]
        fold = self.task.fold
        if coarse and self.task.coarser is not None:
            final = interpolated(self.task.coarser.fold.garment, final, fold.garment)
        return vertex_distances(fold.target, final)

    def _outcome(self, number: int) -> Outcome:
        """The outcome of a finished trial, simulated again if it was before this run; the same to the last bit."""
        if number not in self._kept:
            trial = self.study.trials[number]
            begun = self._begin(trial.params, self.study.is_coarse(trial))
            self._kept[number] = self._ended(begun, f"trial {number}").outcome
        return self._kept[number]


def _added(trial: FrozenTrial) -> Added:
    """The addition of disturbances to the objective of a trial that could win."""
    held = trial.user_attrs
    return Added(float(held["expected_objective"] - held["objective"]), held["worlds"], tuple(held["hardest"]))
