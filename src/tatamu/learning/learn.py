"""Learning: ask, simulate, score, tell, until the trials are done; then write the folder."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from filelock import FileLock, Timeout

from tatamu.errors import InputError, TatamuError
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Outcome, Task
from tatamu.learning import result
from tatamu.learning.samplers import SAMPLERS
from tatamu.learning.space import Grasps, search_space
from tatamu.learning.study import Study

WRITTEN = ("result.json", "manipulation.json", "scene.json", "rollout.npz", "report.html")
"""What a study leaves beside its database."""
MOST_PARALLEL = 16
"""More trials than this at a time know too little of one another."""


@dataclass(frozen=True)
class Progress:
    """How far a study is; given to the caller after every trial."""

    done: int
    trials: int
    best: float | None
    """Least objective so far."""
    best_distance: float | None
    """Mean vertex distance of that trial [m]."""


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
    first: Sequence[dict[str, float]] = (),
    progress: Callable[[Progress], None] = lambda _: None,
) -> Path:
    """Learn a task, or go on where it stopped; the folder then holds everything.

    Args:
        task: What to fold.
        folder: Where the study lives; made if it is not there.
        trials: How many trials the study shall have in the end.
        seed: Of the search.
        sampler: Name of the sampler.
        grasps: Search grasps as whole numbers, or as real numbers that are floored (the paper's way).
        baselines: Also score the fixed trajectories.
        parallel: How many trials run at a time, in threads. Each is proposed knowing all before it but the last
            `parallel` - 1, whether these have ended or not, so that the study does not depend on how fast they are.
        first: Parameters to begin the search with, as many as there are trials for.
        progress: Called when the study is opened and after every trial.

    Returns:
        The report.

    Raises:
        InputError: An argument is out of range, or the folder cannot be used.
        TatamuError: Every trial failed.
    """
    check_search(trials, seed, sampler)
    check_parallel(parallel, task.simulator, task.reach is not None)
    with locked(folder):
        identity = {"task": task.describe(), "sampler": sampler, "grasps": grasps, "seed": seed}
        if parallel > 1:
            identity["parallel"] = parallel
        if first:
            identity["first"] = [dict(parameters) for parameters in first]
        study = Study(folder / "study.db", identity, search_space(task.fold, grasps), floor=task.fold.span)
        done = len(study.trials)
        if trials < done:
            raise InputError(f"trials: {folder} has {done} trials already, given {trials}; give {done} or more")
        if done == trials and _finished(folder, study, baselines):
            return folder / "report.html"
        (folder / "report.html").unlink(missing_ok=True)  # written last: it says that the other files are this study's
        runner = _Runner(task, study)
        progress(runner.progress(trials))
        for _ in runner.run(trials, parallel):
            progress(runner.progress(trials))
        if baselines and study.baselines is None:
            study.baselines = result.baseline_records(task, parallel)
        return runner.write(folder, identity)


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
    if parallel > 1 and simulator != "native":
        raise InputError(f"parallel: only native runs several trials at a time, given {parallel} with {simulator}")
    if parallel > 1 and reaches:
        raise InputError(f"parallel: folds within a robot's reach are tried one at a time, given {parallel}")


def step_name(number: int) -> str:
    """The folder of a step of a plan, the first being 0."""
    return f"step-{number + 1}"


def begun(folder: Path) -> bool:
    """Whether a study, or a plan of several steps, was begun there."""
    return any(os.path.exists(folder / name) for name in ("study.db", step_name(0)))


def locked(folder: Path) -> Any:
    """A lock on the folder that ends with the process, however it ends.

    Raises:
        InputError: The folder cannot be written, another run has it, or it holds such files of somebody else.
    """
    foreign = [name for name in WRITTEN if os.path.exists(folder / name)]
    if foreign and not begun(folder):
        raise InputError(f"{folder}: holds a {foreign[0]} but no study, and it would be lost; give another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / ".lock")
        return lock.acquire(timeout=0)
    except Timeout:
        raise InputError(f"{folder}: another run is learning here") from None
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror or error})") from None


def _finished(folder: Path, study: Study, baselines: bool) -> bool:
    return all((folder / name).exists() for name in WRITTEN) and not (baselines and study.baselines is None)


class _Proposal(NamedTuple):
    """A trial that is on its way."""

    parameters: dict[str, float]
    manipulation: Manipulation


class _Runner:
    """Trials of one study; the outcomes that the report shows are kept, others are forgotten."""

    def __init__(self, task: Task, study: Study) -> None:
        self.task, self.study = task, study
        self._kept: dict[int, Outcome] = {}
        for trial in study.trials:  # a reach that learns from what it is asked knows what it would know without a pause
            task.out_of_reach(task.manipulation(trial.params))

    def run(self, trials: int, parallel: int) -> Iterator[None]:
        """Run trials until there are so many; yields after each, in order."""
        pending: deque[tuple[_Proposal, Future[tuple[Outcome, float]]]] = deque()
        begin = len(self.study.trials)
        with ThreadPoolExecutor(parallel) as pool:
            for number in range(begin, trials):
                if number == begin + parallel:
                    self.study.warm_up()  # now, while trials run
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
        """What came of a manipulation, and how long it took [s]."""
        started = perf_counter()
        return self.task.evaluate(manipulation), perf_counter() - started

    def _finish(self, proposal: _Proposal, future: Future[tuple[Outcome, float]]) -> None:
        """Record a trial when it has ended."""
        outcome, seconds = future.result()
        attributes = result.attributes_of(outcome, proposal.manipulation.trajectory_length, seconds)
        self.study.tell(proposal.parameters, outcome.objective, attributes)
        trials = self.study.trials
        self._kept[len(trials) - 1] = outcome
        needed = {*self._shown().values(), result.best_number(trials)}
        self._kept = {number: kept for number, kept in self._kept.items() if number in needed}

    def progress(self, trials: int) -> Progress:
        """How far the study is."""
        done = self.study.trials
        best = result.best_number(done)
        return Progress(
            done=len(done),
            trials=trials,
            best=None if best is None else done[best].value,
            best_distance=None if best is None else done[best].user_attrs["mean_vertex_distance"],
        )

    def write(self, folder: Path, identity: dict[str, Any]) -> Path:
        """Write the folder and its report."""
        from tatamu.report import write_report

        trials = self.study.trials
        best = result.best_number(trials)
        outcome = None if best is None else self._outcome(best)
        result.write_result(folder, identity, self.task.asked, trials, self.study.baselines, outcome)
        if best is None or outcome is None:
            raise TatamuError(
                f"{folder}: all {len(trials)} trials failed; the last said: {trials[-1].user_attrs['error']}"
            )
        shown = self._shown()
        errors = {
            name: result.errors_of(self.task, self._outcome(shown[name]).rollout)  # type: ignore[arg-type]
            for name in shown
        }
        assert outcome.rollout is not None
        result.write_best(folder, self.task, self.task.manipulation(trials[best].params), outcome.rollout, errors)
        return write_report(folder)

    def _shown(self) -> dict[str, int]:
        """Trials that the histograms show: best of the first 1, 10 and 50, if there are so many."""
        from tatamu.report.fold import MOMENTS

        trials = self.study.trials
        counts = {name: count for name, (count, _) in MOMENTS.items() if count <= len(trials)}
        numbers = {name: result.best_number(trials, count) for name, count in counts.items()}
        return {name: number for name, number in numbers.items() if number is not None}

    def _outcome(self, number: int) -> Outcome:
        """The outcome of a finished trial, simulated again if it was before this run; the same to the last bit."""
        if number not in self._kept:
            parameters = self.study.trials[number].params
            self._kept[number] = self.task.evaluate(self.task.manipulation(parameters))
        return self._kept[number]
