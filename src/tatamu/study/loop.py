"""The loop of a study: it asks, evaluates, records and tells, until all trials are made.

Trials may end in any order; they are recorded and told in the order in which they were asked. A study therefore does
not depend on the number of processors, and a resumed one repeats the same calls.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, Literal

import numpy as np

from tatamu.base.errors import InputError, WorkerKilledError
from tatamu.evaluation.disturbances import Disturbances, Stream, sample_scenarios
from tatamu.evaluation.draws import Draws, Subject
from tatamu.evaluation.evaluator import Ask, Evaluation, Evaluator
from tatamu.evaluation.nominal import Nominal, refuse, unsimulated
from tatamu.evaluation.success import Success
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import Limits, vertex_distances
from tatamu.folding.task import Task
from tatamu.search import Parameters, Proposal, Search
from tatamu.study.record import StudyRecord
from tatamu.study.result import FAILED, MOMENTS
from tatamu.study.trial import Baseline, Trial

if TYPE_CHECKING:
    from tatamu.study.store import StudyStore

Stage = Literal["trials", "first", "baselines", "success", "report"]
Trials = int | Literal["auto"]
Tested = tuple[Success | None, dict[str, np.ndarray]]
"""How often a fold succeeds, and arrays for `rollout.npz`: where the cloth ends in the first scenario of each cause of
failure [m], shape (n, 3), named by `FAILED`. A hand that meets the table or misses the cloth moves no cloth."""
MIN_GAIN = 0.001
"""The search ends when three proposals in a row expect a smaller gain, as a fraction of the best objective."""
SUCCESS_SIMULATIONS = 36
"""How many scenarios the best fold is simulated in that were not used to learn it."""


@dataclass(frozen=True)
class Progress:
    """How far a study is."""

    done: int
    """How many trials have ended."""
    trials: int
    """How many trials there are at most."""
    best: float | None = None
    """The lowest value so far; None if no trial succeeded."""
    best_distance: float | None = None
    """Mean distance of the best fold from its target [m]."""
    stage: Stage = "trials"
    disturbed: bool = False
    step: int = 1
    steps: int = 1
    title: str = ""
    simulated: int = 0
    """How many scenarios of the stage `success` were simulated."""
    simulations: int = SUCCESS_SIMULATIONS
    """How many scenarios the stage `success` has."""

    def __str__(self) -> str:
        """Return one line."""
        step = f"step {self.step} of {self.steps}, " if self.steps > 1 else ""
        found = "" if self.best is None else f", best objective {self.best:.4f}"
        return f"{step}{self.stage}: {self.done}/{self.trials}{found}"


def max_trials(trials: Trials) -> int:
    """Return how many trials there are at most."""
    return 100 if trials == "auto" else trials


def is_over(trials: Trials, made: Sequence[Proposal]) -> bool:
    """Return whether no further trial is to be made."""
    in_a_row = 3
    gains = [each.gain for each in made[-in_a_row:]]
    converged = len(gains) == in_a_row and all(gain is not None and gain < MIN_GAIN for gain in gains)
    return len(made) >= max_trials(trials) or (trials == "auto" and converged)


@dataclass(eq=False)
class Study:
    """A study that runs: an evaluator, a search and a store."""

    evaluator: Evaluator
    search: Search
    store: StudyStore
    record: StudyRecord
    executor: Executor
    wanted: Trials
    show: Callable[[Progress], object]
    """Is called after every new trial, and when another stage starts."""
    _told: list[Trial] = field(default_factory=list, init=False, repr=False)
    """Trials that the search knows, a beginning of `trials`."""
    _kept: dict[int, Evaluation] = field(default_factory=dict, init=False, repr=False)
    _first: Evaluation | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        """Read the trials that are stored.

        Raises:
            InputError: If the store contains another study, or trials outside the bounds of the search.
        """
        self.trials = self.store.open(self.record)
        self._stored = len(self.trials)
        for trial in self.trials:
            try:
                self.search.space.check(trial.parameters)
            except InputError as error:
                raise InputError(f"{self.store.label}: trial {trial.number}: {error}; give another folder") from None

    @property
    def task(self) -> Task:
        return self.evaluator.task

    @property
    def baselines(self) -> list[Baseline] | None:
        """The fixed trajectories; None if they were not simulated yet."""
        return self.store.baselines

    @property
    def is_over(self) -> bool:
        """Whether all trials are stored."""
        return is_over(self.wanted, [trial.proposal for trial in self.trials])

    def run(self, baselines: bool, show_first: Callable[[Evaluation], object] | None) -> None:
        """Make the remaining trials, and simulate the fixed trajectories if `baselines`.

        Before the first trial, the first initial curve is simulated without disturbances for `show_first`, which is
        called while the first trials are running.

        Raises:
            InputError: If the search proposes parameters out of bounds, or the evaluator returns no finite number.
        """
        proposals: list[Proposal] = []
        running: deque[tuple[Proposal, Future[Evaluation] | None]] = deque()  # a stored trial has no future
        fixed: dict[str, tuple[Manipulation, Future[Evaluation]]] = {}
        lacking = baselines and self.baselines is None
        if show_first is not None and not self.trials and self.search.first:
            parameters = self.search.first[0]
            self._first = self._result(self._submit(Ask(parameters), undisturbed=True), "first curve", parameters)
            show_first(self._first)
        try:
            while (more := len(proposals) < self._stored or not is_over(self.wanted, proposals)) or running:
                # the first trial runs alone, because it mostly is the reference fold, from which the scenarios follow
                alone = not self._told and self.evaluator.scenario_count > 0
                if more and len(running) < (1 if alone else self.record.parallel):
                    begun = self._begin(len(proposals))
                    proposals.append(begun[0])
                    running.append(begun)
                    continue
                if lacking and not more and not fixed:
                    for name, (_, make) in BASELINES.items():
                        made = make(self.task.fold)
                        fixed[name] = made, self.executor.submit(_timed_fixed, Nominal(self.task), made)
                self._finish(*running.popleft())
            if fixed:
                self.report("baselines")
                self.store.baselines = [
                    Baseline.of(name, manipulation, self._result(future, f"baseline {name}", manipulation))
                    for name, (manipulation, future) in fixed.items()
                ]
        finally:
            for _, future in [*running, *fixed.values()]:
                if future is not None:
                    future.cancel()  # only has an effect after an interruption

    @property
    def _reference(self) -> Trial | None:
        """The reference fold, which is the first that succeeds without disturbances; None if there is none yet."""
        return next((each for each in self._told if each.score is not None and each.score.succeeds), None)

    def _begin(self, number: int) -> tuple[Proposal, Future[Evaluation] | None]:
        """Begin a trial, unless it is stored already."""
        if number < self._stored:
            proposal = self.trials[number].proposal
            self.search.expect(proposal)
            return proposal, None
        proposal = self.search.ask()
        try:
            self.search.space.check(proposal)
        except InputError as error:
            raise InputError(f"sampler: {self.record.sampler} proposed an invalid trial: {error}") from None
        return proposal, self._submit(self._ask(proposal))

    def _ask(self, proposal: Proposal) -> Ask:
        """Return what the evaluator is asked."""
        parameters, count, reference = dict(proposal), self.evaluator.scenario_count, self._reference
        if count and reference is None:
            return Ask(parameters)
        beat = min((each.minimised for each in self._told if each.score is not None), default=np.inf)
        ordered = order_scenarios(reference, self._told, count) if count and reference else None
        return Ask(parameters, ordered, beat)

    def _submit(self, ask: Ask, *, undisturbed: bool = False) -> Future[Evaluation]:
        """Submit an ask to the executor, unless the robot cannot carry it out. Workers do not need the robot."""
        if self._first is not None and self._first.parameters == ask.parameters:
            if self._first.failed or not self.evaluator.scenario_count:
                return _done(self._first)
        refused = refuse(self.task, ask.parameters)
        if refused is not None:
            return _done(refused)
        evaluator = self.evaluator.undisturbed if undisturbed else self.evaluator
        return self.executor.submit(_timed, evaluator, ask)

    def _finish(self, proposal: Proposal, future: Future[Evaluation] | None) -> None:
        """Record a trial if it is new, and tell it to the search."""
        number = len(self._told)
        if future is not None:
            found = self._result(future, f"trial {number}", proposal)
            if not np.isfinite(found.objective):
                name = getattr(self.evaluator, "name", type(self.evaluator).__name__)
                raise InputError(
                    f"evaluate: {name} must return a finite number, but returned {found.objective} for {dict(proposal)}"
                )
            if found.failed_in and set(found.failed_in) <= set((self._reference or found).failed_in):
                found = replace(found, objective=found.nominal)  # it passes all scenarios that count
            trial = Trial.of(number, proposal, found)
            self.store.add(trial, self.search.space)
            self.trials.append(trial)
            self._keep(number, found)
        self.search.tell(proposal, self.trials[number].minimised)
        self._told.append(self.trials[number])
        if future is not None:
            self.report()

    def _result(
        self, future: Future[Evaluation], which: str, made: Mapping[str, int | float] | Manipulation
    ) -> Evaluation:
        """Wait for the result of parameters or a manipulation. An evaluation that killed its processes has failed."""
        try:
            return future.result()
        except WorkerKilledError as error:
            return unsimulated(self.task, made, f"{error} (seed {self.record.seed}, {which})")

    def _keep(self, number: int, found: Evaluation) -> None:
        """Keep an evaluation in memory while its rollout is needed for the result."""
        self._kept[number] = found
        needed = {self.best(), *(self.best(count) for count, _ in MOMENTS.values() if count <= len(self.trials))}
        self._kept = {each: kept for each, kept in self._kept.items() if each in needed}

    def best(self, count: int | None = None) -> int | None:
        """Return the number of the best trial, or of the best of the first `count`; None if none is complete."""
        complete = [trial for trial in self.trials[:count] if trial.state == "complete"]
        return min(complete, key=lambda each: (each.minimised, each.number)).number if complete else None

    def evaluation(self, number: int) -> Evaluation:
        """Return the undisturbed evaluation of a trial with its rollout, which is simulated again if need be."""
        if number not in self._kept or self._kept[number].rollout is None:
            parameters = self.trials[number].parameters
            future = self.executor.submit(_timed, self.evaluator.undisturbed, Ask(parameters))
            self._kept[number] = self._result(future, f"trial {number}", parameters)
        return self._kept[number]

    def moments(self) -> dict[str, np.ndarray]:
        """Return the distances e_i of Eq. (12) of the best trial at several moments of the search [m], shape (n,)."""
        found = {}
        for name, (count, _) in MOMENTS.items():
            best = self.best(count) if count <= len(self.trials) else None
            rollout = None if best is None else self.evaluation(best).rollout
            if rollout is not None:
                found[name] = vertex_distances(self.task.fold.target, rollout.positions[-1])
        return found

    def measure_success(self, disturbances: Disturbances, parameters: Parameters) -> Tested:
        """Simulate a fold in scenarios that were not used to learn it."""
        task = replace(self.task, reach=None)
        scenarios = sample_scenarios(disturbances, SUCCESS_SIMULATIONS, self.record.seed, Stream.JUDGING)
        self.report("success")
        draws = Draws(Subject(task, parameters), self.executor, progress=lambda done, _: self.report("success", done))
        outcomes = draws.outcomes(scenarios)
        success = Success.of(task.fold, outcomes, Limits())
        causes = [outcome.cause(Limits()) for outcome in outcomes]
        simulate, ends = Nominal(task).simulate, {}
        first = [(cause, causes.index(cause)) for cause in dict.fromkeys(causes) if cause is not None]
        futures = [self.executor.submit(simulate, parameters, scenarios[at]) for _, at in first]
        for (cause, at), future in zip(first, futures, strict=True):
            rollout = self._result(future, f"scenario {at}", parameters).rollout
            if rollout is not None:
                ends[FAILED + cause] = rollout.positions[-1]
        return success, ends

    def report(self, stage: Stage = "trials", simulated: int = 0, trial: Trial | None = None) -> None:
        """Show how far the study is, with the best trial, or with the one that is given."""
        best = self.best()
        shown = trial if best is None else self.trials[best]
        now = Progress(
            done=len(self.trials),
            trials=max_trials(self.wanted),
            best=None if shown is None else shown.minimised,
            best_distance=None if shown is None or shown.score is None else shown.score.mean_vertex_distance,
            stage=stage,
            disturbed=self.record.disturbances is not None,
            step=self.task.step[0],
            steps=self.task.step[1],
            title=self.task.title,
            simulated=simulated,
        )
        self.show(now)


def order_scenarios(reference: Evaluation | Trial, others: Sequence[Evaluation | Trial], count: int) -> tuple[int, ...]:
    """Return the scenarios in which the reference fold succeeds, those in which most other folds failed first."""
    failures = Counter(index for each in others for index in each.failed_in)
    able = [index for index in range(count) if index not in reference.failed_in]
    return tuple(sorted(able, key=lambda index: (-failures[index], index)))


def _done(found: Evaluation) -> Future[Evaluation]:
    future: Future[Evaluation] = Future()
    future.set_result(found)
    return future


def _timed(evaluator: Evaluator, ask: Ask) -> Evaluation:
    """Evaluate, measure the time, and drop the rollout of what cannot be the best."""
    started = perf_counter()
    found = evaluator(ask)
    rollout = found.rollout if found.objective < ask.beat else None
    return replace(found, rollout=rollout, seconds=perf_counter() - started)


def _timed_fixed(nominal: Nominal, manipulation: Manipulation) -> Evaluation:
    started = perf_counter()
    found = nominal.fixed(manipulation)
    return replace(found, rollout=None, seconds=perf_counter() - started)
