"""What the loop of `learn` costs beside its simulations: the table "loop" of docs/notes/learning.md.

    python -m benchmarks.loop [--write-docs]

A study of 50 trials of the default towel whose simulations are there at once; a loop of several rounds, of which the
quietest counts, as other work disturbs the others. Ends with an error if a trial costs 30 ms or more.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any
from unittest.mock import patch

import optuna
from optuna.trial import TrialState

from benchmarks.tables import markdown, publish
from tatamu.api import learn
from tatamu.evaluation import Evaluation, Nominal
from tatamu.folding.parameters import first_curves
from tatamu.folding.task import make_task
from tatamu.search import find_search
from tatamu.study.folder import ResultFolder
from tatamu.study.loop import Progress
from tatamu.study.options import LearnOptions

TRIALS = 50
ROUNDS = 5
ALLOWED = 30.0
"""Largest time of a trial with its proposal [ms]."""


class AtOnce(Executor):
    """Evaluator whose calls end at once with the same evaluation."""

    def __init__(self, evaluation: Evaluation) -> None:
        self._evaluation = evaluation

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return an evaluation that has ended."""
        ended: Future[Any] = Future()
        ended.set_result(self._evaluation)
        return ended


@dataclass
class Clock:
    """Seconds that proposals took."""

    seconds: float = 0.0


@contextmanager
def timed_proposals(name: str) -> Iterator[Clock]:
    """Time the proposals of a search while the block runs."""
    clock = Clock()
    kind: Any = find_search(name)
    propose = kind.propose

    def timed(search: Any) -> Any:
        begun = perf_counter()
        try:
            return propose(search)
        finally:
            clock.seconds += perf_counter() - begun

    with patch.object(kind, "propose", timed):
        yield clock


def loop(evaluation: Evaluation, sampler: str, folder: Path) -> tuple[float, float]:
    """Milliseconds for a trial, of the loop beside the proposals and of the proposals; the report is not among them."""
    times: list[float] = []

    def note(progress: Progress) -> None:
        if progress.stage == "trials":
            times.append(perf_counter())

    options = LearnOptions(
        trials=TRIALS, sampler=sampler, parallel=1, disturbances="none", coarse=False, baselines=False
    )
    with timed_proposals(sampler) as clock:
        learn(make_task("towel"), options, out=folder, executor=AtOnce(evaluation), progress=note)
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
    evaluation = Nominal(task)(first_curves(task.fold)[0])
    rows: list[Mapping[str, str]] = []
    worst = 0.0
    with TemporaryDirectory() as made:
        out = Path(made)
        for sampler in ("gp", "random"):
            beside, proposals = min(loop(evaluation, sampler, out / f"{sampler}-{n}") for n in range(ROUNDS))
            worst = max(worst, beside + proposals)
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
    if worst >= ALLOWED:
        raise SystemExit(f"a trial costs {worst:.1f} ms beside its simulation, not below {ALLOWED:g}")
    if options.write_docs:
        publish("loop", f"{table}\n\n{note}")


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder


if __name__ == "__main__":
    main()
