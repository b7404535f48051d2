"""The loop of a study: the search proposes a trial, the trial is evaluated, and the search receives the result.

Trials are evaluated on any executor, and recorded in the order of their proposals.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING, Literal

import numpy as np

from tatamu.base.errors import InputError, WorkerKilledError
from tatamu.evaluation import NOTHING, Evaluation, Evaluator, Nominal
from tatamu.evaluation.disturbances import Disturbances, Stream, mean_world, sample_worlds
from tatamu.evaluation.robustness import FoldOnMesh, Judge, SuccessRate, VerdictCache
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import Limits
from tatamu.search import HIGH, Proposal, Schedule, Search, Space
from tatamu.study.record import StudyRecord
from tatamu.study.result import MOMENTS
from tatamu.study.trial import Baseline, Trial

if TYPE_CHECKING:
    from tatamu.study.store import StudyStore

Stage = Literal["trials", "baselines", "validation", "report"]
"""Names of the stages of a study.

The stages are the trials, the fixed trajectories for comparison, the validation of the best fold, and the report."""
VALIDATION_WORLDS = 36
"""Number of simulations with random disturbances in which the best fold is validated.

If the fold succeeds in all of them, the 95 % interval of its success rate starts at 90 %."""


@dataclass(frozen=True)
class Progress:
    """Progress of a study. The caller receives it after every trial and when a stage starts."""

    done: int
    trials: int
    """Largest number of trials of the study."""
    best: float | None = None
    """Lowest objective so far.

    If a trial is complete on the fine mesh, only trials on the fine mesh are counted. Otherwise trials on the coarse
    mesh are counted.
    """
    best_distance: float | None = None
    """Mean distance between the vertices of the cloth and their targets in the best trial [m]."""
    coarse: bool = False
    """Whether the best trial so far ran on the coarse mesh."""
    stage: Stage = "trials"
    disturbed: bool = False
    """Whether the objective is a mean or a quantile over simulations with disturbances.

    Otherwise it is C of Eq. (10).
    """
    step: int = 1
    """Number of the step in its plan, counted from 1."""
    steps: int = 1
    title: str = ""
    """Title of the step's fold, in a few words."""

    def __str__(self) -> str:
        step = f"step {self.step} of {self.steps}, " if self.steps > 1 else ""
        mesh = " on the coarse mesh" if self.coarse else ""
        found = "" if self.best is None else f", best objective{mesh} {self.best:.4f}"
        return f"{step}{self.stage}: {self.done}/{self.trials}{found}"


class Study:
    """The trials of one study. Only those rollouts that the result needs are kept in memory."""

    def __init__(
        self, evaluator: Evaluator, search: Search, store: StudyStore, record: StudyRecord, executor: Executor
    ) -> None:
        """Open a study.

        Args:
            evaluator: Evaluator of the proposals.
            search: Search that proposes the parameters of the trials.
            store: Storage of the trials.
            record: Task of the study and settings of its search.
            executor: Executor that runs the evaluations.

        Raises:
            InputError: If the storage cannot be read, or contains another study.
        """
        self.evaluator = evaluator
        self.record = record
        self.trials = store.open(record)
        self._stored = len(self.trials)
        self._search = search
        self._store = store
        self._executor = executor
        self._kept: dict[int, Evaluation] = {}
        for trial in self.trials:
            try:
                self.space.check(trial.parameters)
            except InputError as error:
                raise InputError(f"{store.label}: trial {trial.number}: {error}; give another folder") from None

    @property
    def space(self) -> Space:
        """The search space: the range of each parameter of a trial."""
        return self._search.space

    @property
    def baselines(self) -> list[Baseline] | None:
        """The fixed trajectories and their scores; None if they were not scored."""
        return self._store.baselines

    def is_over(self, schedule: Schedule) -> bool:
        """Return whether all trials of a schedule (number of trials and their meshes) have run."""
        return schedule.next_fidelity([trial.proposal(self.record.coarse) for trial in self.trials]) is None

    def run(self, schedule: Schedule, baselines: bool) -> Iterator[Stage]:
        """Run the remaining trials, and then the fixed trajectories.

        A proposal uses the results of all earlier trials except the last `parallel` - 1 trials. The results of these
        last trials are not used even if the trials have ended. Proposals therefore do not depend on the number of
        processors, and a resumed study repeats the same proposals.

        There is one exception. The first trials (scouts, see `Evaluator.scouts`) find the hardest disturbances. The
        first proposal after the scouts uses the results of all scouts.

        Args:
            schedule: Number of trials and their fidelities.
            baselines: Whether to score the fixed trajectories too, if they have no scores yet.

        Yields:
            The name of the current stage, after each new trial, and when only the fixed trajectories remain to be
            simulated.
        """
        proposals: list[Proposal] = []
        known: list[Evaluation] = []
        running: deque[tuple[Proposal, Future[Evaluation]]] = deque()
        fixed: dict[str, tuple[Manipulation, Future[Evaluation]]] = {}
        try:
            while (fidelity := self._next_fidelity(schedule, proposals)) is not None:
                scouted = len(proposals) == self.evaluator.scouts
                while running and (scouted or len(running) == self.record.parallel):
                    if self._finish(known, *running.popleft()):
                        yield "trials"
                begun = self._replay(len(proposals)) or self._begin(fidelity, known)
                proposals.append(begun[0])
                running.append(begun)
            if baselines and self.baselines is None:
                fixed = self._begin_baselines()
            while running:
                if self._finish(known, *running.popleft()):
                    yield "trials"
            if fixed:
                yield "baselines"
                self._store.baselines = [
                    Baseline.of(name, manipulation, self._fixed_result(name, manipulation, future))
                    for name, (manipulation, future) in fixed.items()
                ]
        finally:
            for future in [*(each for _, each in running), *(each for _, each in fixed.values())]:
                future.cancel()  # only has an effect after an interruption, on evaluations that have not started

    def _next_fidelity(self, schedule: Schedule, proposals: Sequence[Proposal]) -> int | None:
        return HIGH if len(proposals) < self._stored else schedule.next_fidelity(proposals)

    def _replay(self, number: int) -> tuple[Proposal, Future[Evaluation]] | None:
        """Return a trial that is already stored, and add it to the search as pending; None if the trial is not stored.

        Trials are stored already if an interrupted study is resumed.
        """
        if number >= self._stored:
            return None
        trial = self.trials[number]
        proposal = trial.proposal(self.record.coarse)
        self._search.expect(proposal)
        self.evaluator.refuse(proposal)  # the robot's later answers depend on its earlier answers
        known: Future[Evaluation] = Future()
        known.set_result(trial.evaluation(self.record.coarse))
        return proposal, known

    def _begin(self, fidelity: int, known: Sequence[Evaluation]) -> tuple[Proposal, Future[Evaluation]]:
        """Propose a trial, and submit it to the executor.

        Raises:
            InputError: If the search proposes parameters outside its space.
        """
        proposal = self._search.ask(fidelity)
        try:
            self.space.check(proposal)
        except InputError as error:
            raise InputError(f"sampler: {self.record.sampler} proposed what it must not: {error}") from None
        beat = self.evaluator.incumbent(known, proposal)
        keep = self._search.needs_residuals
        return proposal, self.evaluator.submit(self._executor, proposal, NOTHING if keep else beat, keep=keep)

    def _finish(self, known: list[Evaluation], proposal: Proposal, future: Future[Evaluation]) -> bool:
        """Wait for the result of a trial, and report it to the search. Return whether the trial is new.

        A new trial is added to the storage. A trial is not new if it was read from the storage.
        """
        number = len(known)
        found = self._result(proposal, future, f"trial {number}")
        new = number >= self._stored
        if new:
            if self._search.needs_residuals and not found.failed:
                found = replace(found, errors=self.evaluator.errors(found))
            trial = Trial.of(
                number,
                proposal,
                found,
                disturbed=self.record.disturbances is not None,
                spacing=self._spacing(proposal),
            )
            self._store.add(trial, self._search.space)
            self.trials.append(trial)
            self._keep(number, found)
        self._search.tell(proposal, found)
        known.append(replace(found, rollout=None))
        return new

    def _result(self, proposal: Proposal, future: Future[Evaluation], which: str) -> Evaluation:
        """Return the result of an evaluation. If the evaluation killed its processes, the result is a failure."""
        try:
            return future.result()
        except WorkerKilledError as error:
            return self.evaluator.fail(proposal, f"{error} (seed {self.record.seed}, {which})")

    def _spacing(self, proposal: Proposal) -> float | None:
        """Return the spacing of the mesh of a trial [m]; None if the study has only one mesh."""
        if self.record.coarse is None or proposal.fidelity != HIGH:
            return self.record.coarse
        return self.evaluator.task.garment.spacing

    def _keep(self, number: int, found: Evaluation) -> None:
        """Keep the rollout of a trial, and delete the rollouts that the result no longer needs."""
        self._kept[number] = found
        needed = {self.best(), *(self.best(count) for count, _ in MOMENTS.values() if count <= len(self.trials))}
        self._kept = {each: kept for each, kept in self._kept.items() if each in needed}

    def best(self, count: int | None = None) -> int | None:
        """Return the number of the complete trial with the lowest objective; None if all trials failed.

        Args:
            count: Number of trials to compare, starting with the first trial; None for all trials. Trials on the coarse
                mesh are compared only if no trial on the fine mesh is complete.
        """
        complete = [trial for trial in self.trials[:count] if trial.state == "complete"]
        fine = [trial for trial in complete if trial.proposal(self.record.coarse).fidelity == HIGH]
        return min(fine or complete, key=lambda each: (each.minimised, each.number)).number if complete else None

    @property
    def succeeded(self) -> bool:
        """Whether any trial on the fine mesh is complete."""
        best = self.best()
        return best is not None and self.trials[best].proposal(self.record.coarse).fidelity == HIGH

    def evaluation(self, number: int) -> Evaluation:
        """Return the evaluation of a complete trial with its rollout.

        The trial is simulated again if its rollout was not kept.
        """
        if number not in self._kept or self._kept[number].rollout is None:
            proposal = self.trials[number].proposal(self.record.coarse)
            nominal = self.evaluator.without_disturbances()
            future = nominal.submit(self._executor, proposal, NOTHING, keep=True)
            self._kept[number] = self._result(proposal, future, f"trial {number}")
        return self._kept[number]

    def moments(self) -> dict[str, np.ndarray]:
        """Return the vertex distances e_i, Eq. (12), of the best trial at several moments of the search [m].

        Each moment is a number of finished trials, and the best of these trials is meant. Each array has the shape
        (n,). The keys are the names in `MOMENTS`, which also contains the numbers of trials.
        """
        counts = {name: count for name, (count, _) in MOMENTS.items() if count <= len(self.trials)}
        numbers = {name: self.best(count) for name, count in counts.items()}
        return {
            name: self.evaluator.errors(self.evaluation(number))
            for name, number in numbers.items()
            if number is not None
        }

    def validate(self, disturbances: Disturbances, parameters: Mapping[str, int | float]) -> SuccessRate:
        """Return the success rate of a fold under random disturbances that were not used to learn the fold."""
        low = self.evaluator.low_fidelity(parameters)
        coarse = None if low is None else FoldOnMesh(*low)
        worlds = sample_worlds(disturbances, VALIDATION_WORLDS, self.record.seed, Stream.JUDGING)
        judge = Judge(FoldOnMesh(self.evaluator, parameters), coarse, self._executor, VerdictCache())
        return SuccessRate.of(
            self.evaluator.task.fold, judge.judge(worlds, Limits(), nominal=mean_world(disturbances)).worlds, Limits()
        )

    def _begin_baselines(self) -> dict[str, tuple[Manipulation, Future[Evaluation]]]:
        nominal = Nominal(self.evaluator.task)
        made = {name: make(nominal.task.fold) for name, (_, make) in BASELINES.items()}
        return {name: (each, self._executor.submit(_timed_fixed, nominal, each)) for name, each in made.items()}

    def _fixed_result(self, name: str, manipulation: Manipulation, future: Future[Evaluation]) -> Evaluation:
        try:
            return future.result()
        except WorkerKilledError as error:
            reason = f"{error} (seed {self.record.seed}, baseline {name})"
            return Nominal(self.evaluator.task).fail_fixed(manipulation, reason)

    def progress(self, trials: int, stage: Stage = "trials") -> Progress:
        """Return the progress of the study."""
        best = self.best()
        found = None if best is None else self.trials[best]
        task = self.evaluator.task
        return Progress(
            done=len(self.trials),
            trials=trials,
            best=None if found is None else found.minimised,
            best_distance=None if found is None or found.score is None else found.score.mean_vertex_distance,
            coarse=found is not None and not self.succeeded,
            stage=stage,
            disturbed=self.record.disturbances is not None,
            step=task.step[0],
            steps=task.step[1],
            title=task.title,
        )


def _timed_fixed(nominal: Nominal, manipulation: Manipulation) -> Evaluation:
    """Evaluate a fixed trajectory without keeping its rollout, and measure the time."""
    started = perf_counter()
    found = nominal.fixed(manipulation)
    return replace(found, rollout=None, seconds=perf_counter() - started)
