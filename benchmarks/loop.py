"""What the loop of `learn` costs beside its simulations and its proposals: the table "loop" of docs/notes/learning.md.

    python -m benchmarks.loop [--write-docs]

A study of 50 trials of the default towel whose simulations are there at once; a loop of several rounds, of which the
quietest counts, as other work disturbs the others. Ends with an error where a trial costs 5 ms or more.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import optuna
from benchmarks.tables import markdown, publish
from optuna.samplers import BaseSampler
from optuna.trial import TrialState

from tatamu.folding.baselines import triangle
from tatamu.folding.task import make_task
from tatamu.learning import learn
from tatamu.learning.evaluation import Evaluation
from tatamu.learning.runner import Progress
from tatamu.learning.samplers import SAMPLERS
from tatamu.results import ResultFolder

TRIALS = 50
ROUNDS = 5
ASKED = 5.0
"""Milliseconds for a trial at most."""


class AtOnce(Executor):
    """Ends every call at once, with the same evaluation."""

    def __init__(self, evaluation: Evaluation) -> None:
        self._evaluation = evaluation

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """An evaluation that has ended."""
        ended: Future[Any] = Future()
        ended.set_result(self._evaluation)
        return ended


@dataclass
class Clock:
    """Seconds that went by in what it wraps."""

    seconds: float = 0.0
    _inside: bool = field(default=False)

    def around(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, timed; calls that it makes to others that are timed count once."""

        def timed(*args: Any, **kwargs: Any) -> Any:
            if self._inside:
                return function(*args, **kwargs)
            self._inside = True
            begun = perf_counter()
            try:
                return function(*args, **kwargs)
            finally:
                self.seconds += perf_counter() - begun
                self._inside = False

        return timed


@contextmanager
def timed_proposals(name: str) -> Iterator[Clock]:
    """Time what a sampler does for its proposals while the block runs."""
    clock = Clock()
    make = SAMPLERS[name]

    def timed(*arguments: Any) -> BaseSampler:
        sampler = make(*arguments)
        for method in ("infer_relative_search_space", "sample_relative", "sample_independent"):
            setattr(sampler, method, clock.around(getattr(sampler, method)))
        return sampler

    SAMPLERS[name] = timed
    try:
        yield clock
    finally:
        SAMPLERS[name] = make


def loop(evaluation: Evaluation, sampler: str, folder: Path) -> tuple[float, float]:
    """Milliseconds for a trial, of the loop beside the proposals and of the proposals; the report is not among them."""
    times: list[float] = []

    def note(progress: Progress) -> None:
        if progress.stage == "trials":
            times.append(perf_counter())

    with timed_proposals(sampler) as clock:
        learn(
            make_task("towel"),
            folder,
            trials=TRIALS,
            sampler=sampler,
            baselines=False,
            executor=AtOnce(evaluation),
            progress=note,
        )
    whole = times[-1] - times[0]
    return 1e3 * (whole - clock.seconds) / TRIALS, 1e3 * clock.seconds / TRIALS


def by_optuna(learned: Path, folder: Path) -> float:
    """Milliseconds in which `Study.add_trial` writes one of the same trials into a file of its own."""
    trials = optuna.load_study(study_name="tatamu", storage=f"sqlite:///{ResultFolder(learned).study_file}").trials
    study = optuna.create_study(storage=f"sqlite:///{folder / 'other.db'}")
    complete = [trial for trial in trials if trial.state == TrialState.COMPLETE]
    begun = perf_counter()
    for trial in complete:
        study.add_trial(trial)
    return 1e3 * (perf_counter() - begun) / len(complete)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    task = make_task("towel")
    evaluation = Evaluation(task.evaluate(triangle(task.fold)), 0.0)
    rows: list[Mapping[str, str]] = []
    worst = 0.0
    with TemporaryDirectory() as made:
        out = Path(made)
        for sampler in ("gp", "random"):
            beside, proposals = min(loop(evaluation, sampler, out / f"{sampler}-{n}") for n in range(ROUNDS))
            worst = max(worst, beside)
            rows.append(
                {
                    "`--sampler`": f"`{sampler}`",
                    "loop, each trial [ms]": f"{beside:.1f}",
                    "proposal [ms]": f"{proposals:.1f}",
                }
            )
        other = min(by_optuna(out / "gp-0", _made(out / f"optuna-{n}")) for n in range(ROUNDS))
    table = markdown(rows)
    note = f"Optuna's own `Study.add_trial` wrote one of these trials in {other:.1f} ms."
    print(f"{table}\n\n{note}", flush=True)
    if worst >= ASKED:
        raise SystemExit(f"a trial costs {worst:.1f} ms beside its simulation and its proposal, not below {ASKED:g}")
    if options.write_docs:
        publish("loop", f"{table}\n\n{note}")


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder


if __name__ == "__main__":
    main()
