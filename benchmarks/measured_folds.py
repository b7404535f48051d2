"""Hidden set-ups whose folds are measured and corrected: the table of docs/notes/observation.md.

    python -m benchmarks.measured_folds [--out FOLDER] [--set-ups N] [--draws N] [--write-docs]

A set-up has systematic errors with the stated deviations, or with twice as large ones. Its folds are carried out by the
simulator, with new random errors each, and measured by a ruler. After none, one and two measured folds the next folds
are simulated with the correction, and once more as if the systematic errors of hands and table were known exactly.
Every set-up is kept; to resume, repeat the command.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count, product
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from benchmarks.tables import arguments, show
from tatamu.after.feedback import Feedback, FeedbackFolder, feedback_of, from_numbers
from tatamu.after.feedback.correction import added, shifts_against
from tatamu.api import learn
from tatamu.evaluation.disturbances import Scenario, Split, disturbed_hands, hand_failure, split
from tatamu.evaluation.nominal import Nominal
from tatamu.folding.manipulation import HandShift
from tatamu.folding.score import MARKS, Score, marks
from tatamu.folding.task import Task, make_task
from tatamu.simulation.side_by_side import processors
from tatamu.study.folder import ResultFolder
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

WIDER = {1.0: "as stated", 2.0: "twice as large"}
"""Deviations of the systematic errors over the stated ones."""
RULER = 0.0015
"""Standard deviation of a measured number [m]."""
LOST = 0.1
"""Mean vertex distance of a fold in which a hand fails [m]."""
TRIES = 30
"""How often a fold is carried out until it can be measured."""
FIRST = 300
"""Seed of the first set-up. The method was chosen with other seeds."""
FOLDS = (0, 1, 2)
"""Numbers of measured folds."""
EXACT = "errors known exactly"

Row = dict[str, Any]


def feedback_before(out: Path, trials: int) -> Feedback:
    """Return a learned towel and its simulated scenarios; what is there is taken."""
    if not ResultFolder(out).report_file.exists():
        learn(make_task("towel"), LearnOptions(trials=trials, seed=0, baselines=False), out=out)
    return feedback_of(Result.load(out), FeedbackFolder(out))


@dataclass(frozen=True)
class SetUp:
    """A hidden set-up."""

    found: Feedback
    """The learned fold, without a measured one."""
    seed: int
    wider: float
    """Deviations of the systematic errors over the stated ones."""

    @property
    def parts(self) -> Split:
        """The stated disturbances."""
        return split(self.found.disturbances)

    def _normal(self, index: int, part: int = 0) -> np.ndarray:
        return np.random.default_rng([self.seed, index, part, 47]).standard_normal(len(self.parts.names))

    @cached_property
    def systematic(self) -> np.ndarray:
        """The systematic errors, shape (k,); drawn again if a hand fails because of them."""
        values, vectors = np.linalg.eigh(self.parts.systematic)
        root = np.asarray(vectors * np.sqrt(np.clip(values, 0.0, None)))  # root root' is the covariance
        drawn = (self.parts.mean + self.wider * root @ self._normal(0, part) for part in count())
        return next(same for same in drawn if self._failure(same, self._task(())) is None)

    def random(self, index: int, part: int = 0) -> np.ndarray:
        """Return random errors of a fold, shape (k,)."""
        return np.sqrt(self.parts.random) * self._normal(index, part)

    def _task(self, shift: Sequence[HandShift]) -> Task:
        task = self.found.learned.task
        return replace(task, shift=added(task.shift, tuple(shift)))

    def _scenario(self, values: np.ndarray) -> Scenario:
        return Scenario(dict(zip(self.parts.names, map(float, values), strict=True)))

    def _failure(self, values: np.ndarray, task: Task) -> str | None:
        manipulation = task.manipulation(self.found.learned.best.parameters)
        return hand_failure(disturbed_hands(task.fold, manipulation, self._scenario(values)))

    def end(self, random: np.ndarray, shift: Sequence[HandShift]) -> tuple[np.ndarray, Score] | None:
        """Return the vertices after a corrected fold, and its score; None if a hand fails."""
        values, task = self.systematic + random, self._task(shift)
        if self._failure(values, task) is not None:
            return None
        found = Nominal(task).simulate(self.found.learned.best.parameters, self._scenario(values))
        return None if found.rollout is None or found.score is None else (found.rollout.positions[-1], found.score)

    def measured(self, found: Feedback, index: int) -> Feedback:
        """Carry a corrected fold out, and measure it.

        It is repeated if a hand fails, or `observe` leaves it out; after `TRIES`, nothing is measured.
        """
        task = self._task(found.correction.shifts)
        for part in range(TRIES):
            end = self.end(self.random(index, part), found.correction.shifts)
            if end is None:
                continue
            true = marks(found.learned.task.fold, end[0])
            errors = RULER * self._normal(1000 + index, part)[: len(MARKS)]
            numbers = {name: (true[name] + float(error), RULER) for name, error in zip(MARKS, errors, strict=True)}
            fold = found.fold(task.shift, from_numbers(numbers, source="ruler"))
            if not (after := found.with_fold(len(found.folds), Path(), fold)).implausible:
                return after
        return found

    def run(self, draws: int) -> Row:
        """Return mean vertex distances and successes of next folds after each number of measured folds."""
        row: Row = {"seed": self.seed, "wider": self.wider, "draws": draws}
        found = self.found
        corrections = {EXACT: self._exact()}
        for folds in FOLDS:
            found = self.measured(found, folds) if folds else found
            corrections[str(folds)] = found.correction.shifts
            row[f"expected {folds}"] = found.correction.after.within
        for kind, shifts in corrections.items():
            ends = [self.end(self.random(100 + index), shifts) for index in range(draws)]
            row[f"distance {kind}"] = [min(LOST, end[1].mean_vertex_distance) if end else LOST for end in ends]
            row[f"success {kind}"] = [bool(end and end[1].succeeds) for end in ends]
        return row

    def _exact(self) -> tuple[HandShift, ...]:
        """Return the correction that undoes the true systematic errors."""
        learned = self.found.learned
        return shifts_against(learned.task.fold, learned.manipulation, self._scenario(self.systematic))


def rows_of(out: Path, set_ups: int, draws: int, trials: int) -> list[Row]:
    """Run the set-ups that are not in the file yet, and return all."""
    file = out / "set-ups.jsonl"
    kept = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    known = {(row["seed"], row["wider"]): row for row in kept if row["draws"] == draws}
    wanted = list(product(range(FIRST, FIRST + set_ups), WIDER))
    if missing := [each for each in wanted if each not in known]:
        found, lock = feedback_before(out, trials), Lock()

        def one(each: tuple[int, float]) -> None:
            row = SetUp(found, *each).run(draws)
            with lock, file.open("a") as opened:
                known[each] = row
                opened.write(json.dumps(row) + "\n")
                print(f"{len(known)} of {len(wanted)} set-ups", flush=True)

        with ThreadPoolExecutor(processors()) as workers:
            list(workers.map(one, missing))
    return [known[each] for each in wanted]


def table(rows: Sequence[Row]) -> Iterator[dict[str, str]]:
    """Yield a row for each number of measured folds, and one for errors that are known exactly."""
    for wider, folds in product(WIDER, (*map(str, FOLDS), EXACT)):
        here = [row for row in rows if row["wider"] == wider]
        before, distance = (np.array([np.median(row[f"distance {each}"]) for row in here]) for each in ("0", folds))
        rates = np.array([np.mean(row[f"success {folds}"]) for row in here])
        yield {
            "systematic errors": WIDER[wider],
            "measured folds": folds,
            "median distance [mm]": interval(1e3 * distance, "{:.1f}"),
            "ratio of medians": f"{np.median(distance) / np.median(before):.2f}",
            "worse by 10 %": f"{int((distance > 1.1 * before).sum())} of {len(here)}",
            "success in the median set-up": interval(100 * rates, "{:.0f} %"),
            "success in all": f"{100 * rates.mean():.0f} %",
            "expected by `tatamu observe`": _expected(here, folds),
        }


def _expected(rows: Sequence[Row], folds: str) -> str:
    """Return the share of folds that the correction expects within the limit; it knows of no failing hand."""
    expected = [row[f"expected {folds}"] for row in rows if f"expected {folds}" in row]
    return f"{100 * np.mean(expected):.0f} %" if expected else "-"


def short(rows: Sequence[Row]) -> str:
    """Return the sentence of README."""
    large = [row for row in rows if row["wider"] == max(WIDER)]
    none, one, two = (f"{100 * np.mean([row[f'success {folds}'] for row in large]):.0f} %" for folds in FOLDS)
    return (
        f"in {len(large)} simulated set-ups with errors twice as large as usual, {none} of the folds succeed, {one}\n"
        f"after one measured fold, and {two} after two."
    )


def interval(values: np.ndarray, form: str) -> str:
    """Return the median and its 90 % interval, by bootstrap of set-ups."""
    chosen = np.random.default_rng(0).integers(0, len(values), (2000, len(values)))
    low, high = np.quantile(np.median(values[chosen], axis=1), (0.05, 0.95))
    return f"{form.format(np.median(values))} ({form.format(low)} to {form.format(high)})"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, default=Path("runs/measured-folds"))
    parser.add_argument("--set-ups", type=int, default=20)
    parser.add_argument("--draws", type=int, default=25)
    parser.add_argument("--trials", type=int, default=50)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows = rows_of(options.out, options.set_ups, options.draws, options.trials)
    show({"measured folds": list(table(rows)), "measured folds: short": short(rows)}, options.write_docs)


if __name__ == "__main__":
    main()
