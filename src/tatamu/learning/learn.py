"""Learning: ask, simulate, score, tell, until the trials are done; then write the folder."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any, Literal, NamedTuple

import numpy as np
from filelock import FileLock, Timeout

from tatamu.errors import InputError, TatamuError
from tatamu.folding.manipulation import Manipulation, scene_of, trajectory_lengths
from tatamu.folding.score import vertex_distances
from tatamu.folding.task import Outcome, Task
from tatamu.learning.outcomes import attributes_of, best_number, result_of, scored_baselines
from tatamu.learning.samplers import SAMPLERS
from tatamu.learning.space import Grasps, search_space
from tatamu.learning.study import Identity, OptunaStudy
from tatamu.results import MOMENTS, ResultFolder, describe_manipulation, describe_task
from tatamu.results.folder import LEARNED
from tatamu.results.result import Parameters
from tatamu.simulators import SIMULATORS, capabilities

MOST_PARALLEL = 16
"""Trials at a time at most: more would know too little of one another."""


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


def learn(
    task: Task,
    folder: Path,
    *,
    trials: int = 50,
    seed: int = 0,
    sampler: str = "gp",
    grasps: Grasps = "integer",
    baselines: bool = True,
    parallel: int = 1,
    first: Sequence[Parameters] = (),
    progress: Callable[[Progress], None] = lambda _: None,
) -> Path:
    """Learn a task, or go on where it stopped; the folder then holds everything.

    Args:
        task: The fold, the garment and the simulator.
        folder: Where the study lives; made if it is not there.
        trials: How many trials the study shall have in the end.
        seed: Of the search.
        sampler: Name of the sampler.
        grasps: Search grasps as whole numbers, or as real numbers that are floored, as in the paper.
        baselines: Also score the fixed trajectories.
        parallel: How many trials run at a time, in threads. Each is proposed knowing all before it but the last
            `parallel` - 1, whether these have ended or not, so that the study does not depend on how fast they are.
        first: Parameters to begin the search with, as many as there are trials for.
        progress: Called when the study is opened, after every trial, and when another stage begins.

    Returns:
        The report.

    Raises:
        InputError: An argument is out of range, or the folder cannot be used.
        TatamuError: Every trial failed.
        KeyboardInterrupt: The user ended it; what is finished is then written with a report, as far as there is any.
    """
    check_search(trials, seed, sampler)
    check_parallel(parallel, task.simulator, task.reach is not None)
    results = ResultFolder(folder)
    with locked(results):
        identity = Identity(
            task=describe_task(task),
            sampler=sampler,
            grasps=grasps,
            seed=seed,
            parallel=parallel,
            first=[dict(parameters) for parameters in first],
        )
        lengths = partial(trajectory_lengths, task.fold)
        study = OptunaStudy(results.study_file, identity, search_space(task.fold, grasps), lengths)
        done = len(study.trials)
        if trials < done:
            raise InputError(f"trials: {folder} has {done} trials already, given {trials}; give {done} or more")
        if done == trials and results.complete and not (baselines and study.baselines is None):
            return results.report_file
        results.report_file.unlink(missing_ok=True)  # written last: it says that the other files are this study's
        runner = _Runner(task, study)
        try:
            progress(runner.progress(trials))
            for _ in runner.run(trials, parallel):
                progress(runner.progress(trials))
            if baselines and study.baselines is None:
                progress(runner.progress(trials, "baselines"))
                study.baselines = scored_baselines(task, parallel)
            progress(runner.progress(trials, "report"))
            return runner.write(results)
        except KeyboardInterrupt:
            if runner.succeeded:
                progress(runner.progress(trials, "report"))
                runner.write(results)
            raise


def check_search(trials: int, seed: int, sampler: str) -> None:
    """Refuse a search that cannot be."""
    if not 1 <= trials <= 10_000:
        raise InputError(f"trials: must be from 1 to 10000, given {trials}")
    if not 0 <= seed < 2**32:
        raise InputError(f"seed: must be from 0 to {2**32 - 1}, given {seed}")
    if sampler not in SAMPLERS:
        raise InputError(f"sampler: must be one of {', '.join(SAMPLERS)}, given {sampler!r}")


def check_parallel(parallel: int, simulator: str, reaches: bool) -> None:
    """Refuse to run more trials at a time than a simulator, or a robot's reach, can."""
    if not 1 <= parallel <= MOST_PARALLEL:
        raise InputError(f"parallel: must be from 1 to {MOST_PARALLEL}, given {parallel}")
    if parallel > 1 and not capabilities(simulator).parallel:
        able = ", ".join(name for name in SIMULATORS if capabilities(name).parallel)
        raise InputError(f"parallel: only {able} runs several trials at a time, given {parallel} with {simulator}")
    if parallel > 1 and reaches:
        raise InputError(f"parallel: folds within a robot's reach are tried one at a time, given {parallel}")


def locked(folder: ResultFolder) -> Any:
    """A lock on the folder that ends with the process, however it ends.

    Raises:
        InputError: The folder cannot be written, another run has it, or it holds such files of somebody else.
    """
    path = folder.path
    foreign = [name for name in LEARNED if os.path.exists(path / name)]
    if foreign and not folder.begun:
        raise InputError(f"{path}: holds a {foreign[0]} but no study, and it would be lost; give another folder")
    try:
        path.mkdir(parents=True, exist_ok=True)
        lock = FileLock(path / ".lock")
        return lock.acquire(timeout=0)
    except Timeout:
        raise InputError(f"{path}: another run is learning here") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None


class _Proposal(NamedTuple):
    """A trial that is running."""

    parameters: Parameters
    manipulation: Manipulation


class _Runner:
    """Trials of one study; the outcomes that the folder keeps are remembered, others are forgotten."""

    def __init__(self, task: Task, study: OptunaStudy) -> None:
        self.task, self.study = task, study
        self._kept: dict[int, Outcome] = {}
        for trial in study.trials:  # a reach that learns from what it is asked knows what it would know without a pause
            task.out_of_reach(task.manipulation(trial.params))

    def run(self, trials: int, parallel: int) -> Iterator[None]:
        """Run trials until there are `trials` of them; yields after each, in order."""
        pending: deque[tuple[_Proposal, Future[tuple[Outcome, float]]]] = deque()
        begin = len(self.study.trials)
        with ThreadPoolExecutor(parallel) as pool:
            for number in range(begin, trials):
                if len(pending) == parallel:
                    self._finish(*pending.popleft())
                    yield
                parameters = self.study.ask([p.parameters for p, _ in pending], max(0, number - parallel + 1))
                proposal = _Proposal(parameters, self.task.manipulation(parameters))
                pending.append((proposal, pool.submit(self._evaluate, proposal.manipulation)))
            while pending:
                self._finish(*pending.popleft())
                yield

    def _evaluate(self, manipulation: Manipulation) -> tuple[Outcome, float]:
        """The outcome of a manipulation, and how long it took [s]."""
        started = perf_counter()
        return self.task.evaluate(manipulation), perf_counter() - started

    def _finish(self, proposal: _Proposal, future: Future[tuple[Outcome, float]]) -> None:
        """Record a trial when it has ended."""
        outcome, seconds = future.result()
        attributes = attributes_of(outcome, proposal.manipulation.trajectory_length, seconds)
        self.study.tell(proposal.parameters, outcome.objective, attributes)
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
        """e_i of a complete trial, Eq. (12) [m], shape (n,)."""
        rollout = self._outcome(number).rollout
        assert rollout is not None, "the trial is complete"
        return vertex_distances(self.task.fold.target, rollout.positions[-1])

    def _outcome(self, number: int) -> Outcome:
        """The outcome of a finished trial, simulated again if it was before this run; the same to the last bit."""
        if number not in self._kept:
            parameters = self.study.trials[number].params
            self._kept[number] = self.task.evaluate(self.task.manipulation(parameters))
        return self._kept[number]
