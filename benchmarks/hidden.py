"""Hidden set-ups: what is wrong with hands, table and cloth is drawn, and folds are carried out in a simulator.

A set-up is drawn twice as uncertain as usual. Its systematic part is the same in all of its folds, the random part is
new in each. Folds in which a hand misses the cloth or meets the table are drawn again: that is seen without measuring.
Folds are measured with a ruler or by a photograph.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from benchmarks.photographs import Setting
from tatamu.after.feedback import ObservedFolder, from_numbers
from tatamu.after.feedback.correction import added
from tatamu.after.feedback.observe import Evidence, evidence_of
from tatamu.after.feedback.posterior import Fold
from tatamu.api import learn
from tatamu.base.errors import InputError
from tatamu.evaluation import Nominal
from tatamu.evaluation.disturbances import Split, World, hand_failure, split
from tatamu.folding.marks import MARKS, marks
from tatamu.folding.shift import HandShift
from tatamu.folding.task import Task, make_task
from tatamu.study.folder import ResultFolder
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

WIDER = 2.0
"""Deviations of the hidden set-ups over the usual ones."""
RULER = 0.0015
"""Standard deviation of a measured number [m]."""
LOST = 0.2
"""Mean vertex distance of a fold that failed [m]."""
FIRST = 100
"""Seed of the first set-up. The methods were chosen on set-ups with lower seeds, so they are tested on others."""
TRIALS = 24
"""Trials of the learned folds."""

Shifts = tuple[HandShift, ...]
Row = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """A fold, and the number of set-ups in which it is carried out."""

    name: str
    garment: str
    fold: str
    set_ups: int
    size: tuple[float, float] | None = None
    spacing: float = 0.04
    reality: str = "native"
    """Simulator that plays reality."""
    by_photo: bool = False
    """Whether folds are read from photographs instead of measured with a ruler."""
    learned: str = ""
    """Case whose learned fold is used; empty for its own."""

    @property
    def file_name(self) -> str:
        """Name of the case in file names."""
        return self.name.replace(", ", "-").replace(" ", "-")


TOWEL = Case("towel", "towel", "half", 20, (0.30, 0.50), 0.025)
CASES = (
    TOWEL,
    Case("T-shirt, half", "tshirt", "half", 10),
    Case("trousers, leg", "trousers", "leg", 10, spacing=0.025),
    replace(TOWEL, name="towel, by photo", set_ups=5, by_photo=True, learned="towel"),
    replace(TOWEL, name="towel, MuJoCo as reality", set_ups=6, reality="mujoco", learned="towel"),
)


def evidence_for(case: Case, out: Path) -> Evidence:
    """Learn the fold of a case in usual disturbances, and simulate its draws; what is there is taken."""
    folder = out / (case.learned or case.file_name)
    if not ResultFolder(folder).report_file.exists():
        task = make_task(case.garment, size=case.size, spacing=case.spacing, fold=case.fold)
        learn(task, LearnOptions(trials=TRIALS, seed=0, baselines=False, coarse=False), out=folder)
    learned = Result.load(folder)
    print(f"{case.name}: {learned.held.headline if learned.held else ''}", flush=True)
    return evidence_of(learned, ObservedFolder(folder))


@dataclass(frozen=True)
class SetUp:
    """A hidden set-up."""

    evidence: Evidence
    seed: int
    case: Case

    @property
    def parts(self) -> Split:
        """The usual disturbances."""
        return split(self.evidence.disturbances)

    def _normal(self, number: int, part: int = 0) -> np.ndarray:
        """Return standard normal numbers, shape (k,)."""
        return np.random.default_rng([self.seed, number, part, 47]).standard_normal(len(self.parts.names))

    @cached_property
    def systematic(self) -> np.ndarray:
        """What is the same in every fold, shape (k,); drawn again if a hand cannot do its part because of it."""
        drawn = (self.parts.mean + WIDER * self.parts.root @ self._normal(0, part) for part in count())
        return next(same for same in drawn if not self._fails(same))

    def random(self, number: int) -> np.ndarray:
        """What is new in a fold, shape (k,); drawn again if a hand cannot do its part without a correction."""
        drawn = (WIDER * np.sqrt(self.parts.random) * self._normal(number, part) for part in count())
        return next(new for new in drawn if not self._fails(self.systematic + new) and not self._fails(new))

    def _fails(self, values: np.ndarray, shift: Shifts = ()) -> bool:
        task = self._task(shift)
        manipulation = task.manipulation(self.evidence.base.best.parameters)
        return hand_failure(task.fold, manipulation, self._world(values)) is not None

    def _task(self, shift: Shifts) -> Task:
        task = self.evidence.base.task
        return replace(task, shift=added(task.shift, shift), simulator=self.case.reality)

    def _world(self, values: np.ndarray) -> World:
        return World(dict(zip(self.parts.names, map(float, values), strict=True)))

    def fold(self, values: np.ndarray, shift: Shifts = ()) -> tuple[np.ndarray | None, float]:
        """Carry a fold out with a correction; return where the cloth lies, and how far off [m].

        Nothing and `LOST` if the correction sends a hand beside the cloth or into the table.
        """
        if self._fails(values, shift):
            return None, LOST
        found = Nominal(self._task(shift)).in_world(self.evidence.base.best.parameters, self._world(values))
        if found.rollout is None or found.score is None:
            return None, LOST
        return found.rollout.positions[-1], min(LOST, found.score.mean_vertex_distance)

    def distance(self, values: np.ndarray, shift: Shifts = ()) -> float:
        """Return how far a fold ends from its target [m]."""
        return self.fold(values, shift)[1]

    def observed(self, number: int, shift: Shifts = ()) -> list[Fold]:
        """Carry a fold out and measure it; nothing if there is nothing to measure."""
        final, _ = self.fold(self.systematic + self.random(number), shift)
        if final is None:
            return []
        if not self.case.by_photo:
            true = marks(self.evidence.base.task.fold, final)
            errors = RULER * self._normal(1000 + number)[: len(MARKS)]
            numbers = {n: (float(np.clip(true[n] + e, -1.9, 1.9)), RULER) for n, e in zip(MARKS, errors, strict=True)}
            return [self.evidence.fold(shift, from_numbers(numbers, source="ruler"))]
        try:
            numbers = self._setting.read(final, number).values
        except InputError as error:
            print(f"  {self.seed}, {number}: {error}", flush=True)
            return []
        return [self.evidence.fold(shift, from_numbers(numbers, source="photo"))]

    @cached_property
    def _setting(self) -> Setting:
        """Table, board and camera, with a photograph before the first fold."""
        return Setting(self.evidence.base.task.fold, self.seed)


def measured_rows(
    case: Case, set_ups: int, out: Path, kind: str, measure: Callable[[SetUp], Mapping[str, Any]], threads: int
) -> list[Row]:
    """Measure the set-ups that are not in the case's file yet, and return all."""
    file = out / f"{case.file_name}-{kind}.jsonl"
    known: dict[int, Row] = {}
    if file.exists():
        known = {row["seed"]: row for row in map(json.loads, file.read_text().splitlines())}
    seeds = range(FIRST, FIRST + set_ups)
    missing = [seed for seed in seeds if seed not in known]
    if missing:
        evidence, lock = evidence_for(case, out), Lock()

        def one(seed: int) -> None:
            row = {"seed": seed, **measure(SetUp(evidence, seed, case))}
            with lock, file.open("a") as opened:
                known[seed] = row
                opened.write(json.dumps(row) + "\n")
                print(f"{case.name}, {kind}: {len(known)} of {set_ups}", flush=True)

        with ThreadPoolExecutor(threads) as workers:
            list(workers.map(one, missing))
    return [known[seed] for seed in seeds]
