"""Hidden set-ups that are observed and corrected: the tables of docs/notes/observation.md.

    python -m benchmarks.loop_closed [--out FOLDER] [--cases towel ..] [--set-ups N] [--tried N] [--write-docs]

Each set-up is drawn twice as uncertain as usual: its systematic part is fixed, the random part new in each fold. A fold
is carried out by a simulator, its marks are measured with 1.5 mm of error, the next fold is corrected, observed, and
corrected again. Every fold is kept; to resume, repeat the command.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from benchmarks.tables import markdown, publish

from tatamu.api import learn
from tatamu.disturbances import Split, World, hand_errors, split
from tatamu.evaluation import Nominal
from tatamu.folding.marks import MARKS, marks
from tatamu.folding.shift import HandShift
from tatamu.folding.task import make_task
from tatamu.observation import ObservedFolder, from_numbers
from tatamu.observation.correction import CORRECTABLE, added, find_correction, shift_against
from tatamu.observation.draws import USUAL
from tatamu.observation.observe import Evidence, evidence_of
from tatamu.observation.posterior import Fold, posterior
from tatamu.options import LearnOptions
from tatamu.study import Result

WIDER = 2.0
"""Deviations of the hidden set-ups over the usual ones."""
RULER = 0.0015
"""Standard deviation of a measured number [m]."""
LOST = 0.2
"""Mean vertex distance of a fold that failed [m]."""
FEWEST_EFFECTIVE = 20
"""Effective draws that importance weights are tempered to."""
SLACK = 5e-4
"""A fold is no worse if it ends this much farther off at most [m]."""

Shifts = tuple[HandShift, ...]


@dataclass(frozen=True)
class Case:
    """A fold, and in how many set-ups it is carried out."""

    name: str
    garment: str
    fold: str
    size: tuple[float, float] | None
    spacing: float
    hands: int | None
    set_ups: int
    reality: str = "native"
    """Simulator that plays reality."""
    learned: str = ""
    """Case whose learned fold is taken; empty for its own."""


CASES = (
    Case("towel", "towel", "half", (0.30, 0.50), 0.025, None, 20),
    Case("T-shirt, half", "tshirt", "half", None, 0.04, None, 10),
    Case("trousers, leg", "trousers", "leg", None, 0.04, None, 10),
    Case("towel, MuJoCo as reality", "towel", "half", (0.30, 0.50), 0.025, None, 6, "mujoco", "towel"),
)


def learned_fold(case: Case, out: Path) -> Result:
    """Learn the fold of a case in usual disturbances, or read it."""
    folder = out / (case.learned or case.name).replace(", ", "-").replace(" ", "-")
    task = make_task(case.garment, size=case.size, spacing=case.spacing, fold=case.fold, hands=case.hands)
    found = learn(task, LearnOptions(trials=24, seed=0, baselines=False, coarse=False), out=folder)
    assert isinstance(found, Result)
    return found


@dataclass(frozen=True)
class SetUp:
    """A hidden set-up."""

    evidence: Evidence
    seed: int
    simulator: str

    @property
    def parts(self) -> Split:
        """Usual disturbances."""
        return split(self.evidence.disturbances)

    def _generator(self, number: int) -> np.random.Generator:
        return np.random.default_rng(np.random.SeedSequence([self.seed, number, 47]))

    @property
    def systematic(self) -> np.ndarray:
        """What is the same in every fold, shape (k,)."""
        parts = self.parts
        return parts.mean + WIDER * parts.root @ self._generator(0).standard_normal(len(parts.names))

    def random(self, number: int) -> np.ndarray:
        """What is new in a fold, shape (k,)."""
        return WIDER * np.sqrt(self.parts.random) * self._generator(number).standard_normal(len(self.parts.names))

    def fold(self, values: np.ndarray, shift: Shifts) -> tuple[dict[str, float] | None, float]:
        """Carry a fold out with a correction; return its marks and its mean vertex distance [m]."""
        base = self.evidence.base
        task = replace(base.task, shift=added(base.task.shift, shift), simulator=self.simulator)
        world = World(dict(zip(self.parts.names, map(float, values), strict=True)))
        found = Nominal(task).in_world(base.best.parameters, world)
        if found.rollout is None or found.score is None:
            return None, LOST
        return marks(task.fold, found.rollout.positions[-1]), min(LOST, found.score.mean_vertex_distance)

    def measured(self, found: Mapping[str, float], number: int, shift: Shifts) -> Fold:
        """Measure a fold with a ruler."""
        generator = self._generator(100 + number)
        numbers = {
            name: (float(np.clip(found[name] + RULER * generator.standard_normal(), -1.9, 1.9)), RULER)
            for name in MARKS
        }
        return self.evidence.fold(shift, from_numbers(numbers, source="ruler"))


def run(set_up: SetUp) -> dict[str, Any]:
    """Observe and correct one set-up twice."""
    evidence = set_up.evidence
    same = set_up.systematic
    first, start = set_up.fold(same + set_up.random(1), ())
    _, plain = set_up.fold(same + set_up.random(2), ())
    _, alone = set_up.fold(set_up.random(2), ())
    row: dict[str, Any] = {"seed": set_up.seed, "first": start, "plain": plain, "alone": alone, "inside": [], "of": 0}
    folds: list[Fold] = []
    seen = first
    shift: Shifts = ()
    for number in (1, 2):
        if seen is not None:
            folds.append(set_up.measured(seen, number, shift))
        if folds:
            found = posterior(evidence.disturbances, folds)
            correction = find_correction(found, evidence.emulator, evidence.base.task.fold, evidence.base.manipulation)
            shift = correction.shifts
            if found.used:
                low, high = np.quantile(found.members, (0.05, 0.95), axis=0)
                row["inside"].append(int(((low <= same) & (same <= high))[np.diag(found.prior.systematic) > 0].sum()))
                row["of"] = int((np.diag(found.prior.systematic) > 0).sum())
        seen, row[f"after {number}"] = set_up.fold(same + set_up.random(number + 1), shift)
        row[f"implausible {number}"] = bool(folds) and not found.used
    _, row["plain 2"] = set_up.fold(same + set_up.random(3), ())
    _, row["alone 2"] = set_up.fold(set_up.random(3), ())
    return row


def updates(set_up: SetUp) -> dict[str, Any]:
    """Correct one set-up after one observed fold by each update."""
    evidence = set_up.evidence
    same = set_up.systematic
    seen, _ = set_up.fold(same + set_up.random(1), ())
    _, plain = set_up.fold(same + set_up.random(2), ())
    row: dict[str, Any] = {"seed": set_up.seed, "none": plain}
    for name, update in UPDATES.items():
        shift: Shifts = () if seen is None else update(evidence, set_up.measured(seen, 1, ()))
        _, row[name] = set_up.fold(same + set_up.random(2), shift)
    return row


def tempered(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct as tatamu does."""
    found = posterior(evidence.disturbances, [fold])
    return find_correction(found, evidence.emulator, evidence.base.task.fold, evidence.base.manipulation).shifts


def without_width(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct as tatamu does, with deviations taken as they are stated."""
    with patch("tatamu.observation.posterior.WIDTH", 0.0):
        return tempered(evidence, fold)


def ensemble(evidence: Evidence) -> tuple[Split, np.ndarray, np.ndarray]:
    """Return the systematic parts (n, k) of the usual draws, drawn given their sum, and their marks (n, m)."""
    parts = split(evidence.disturbances)
    known = evidence.draws.worlds[1 : 1 + USUAL]
    generator = np.random.default_rng(0)
    share = np.diag(parts.systematic) / np.maximum(parts.deviations**2, 1e-30)
    deviation = np.sqrt(share * (1.0 - share)) * parts.deviations
    rows, seen = [], []
    for world, verdict in known:
        if verdict.marks is None:
            continue
        values = np.array([world[name] for name in parts.names])
        rows.append(parts.mean + share * (values - parts.mean) + deviation * generator.standard_normal(len(values)))
        seen.append([verdict.marks[name] for name in MARKS])
    return parts, np.array(rows), np.array(seen) + evidence.draws.difference


def kalman(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct by a plain ensemble Kalman update of the draws."""
    parts, members, seen = ensemble(evidence)
    seen = seen[:, fold.places]
    centred = seen - seen.mean(axis=0)
    gain = (
        (members - members.mean(axis=0)).T
        @ centred
        @ np.linalg.inv(centred.T @ centred + len(seen) * RULER**2 * np.eye(seen.shape[1]))
    )
    return _against(evidence, parts, parts.mean + gain @ (fold.values - seen.mean(axis=0)))


def weighted(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct by importance weights of the draws, tempered until enough of them are effective."""
    parts, members, seen = ensemble(evidence)
    squared = ((seen[:, fold.places] - fold.values) ** 2).sum(axis=1) / RULER**2
    for power in np.geomspace(1.0, 1e-6, 60):
        weights = np.exp(-0.5 * power * (squared - squared.min()))
        weights /= weights.sum()
        if 1.0 / (weights**2).sum() >= FEWEST_EFFECTIVE:
            break
    return _against(evidence, parts, weights @ members)


def _against(evidence: Evidence, parts: Split, mean: np.ndarray) -> Shifts:
    """Return the shift against a mean of the systematic parts."""
    values = {name: float(value) for name, value in zip(parts.names, mean, strict=True) if _correctable(name)}
    base = evidence.base
    return shift_against(hand_errors(base.task.fold, base.manipulation, World(values)))


def _correctable(name: str) -> bool:
    return any(f"{name}.".startswith(f"{part}.") for part in CORRECTABLE)


UPDATES: Mapping[str, Callable[[Evidence, Fold], Shifts]] = {
    "tempered, on the emulator": tempered,
    "the same, width as stated": without_width,
    "plain ensemble Kalman": kalman,
    "importance weights of draws": weighted,
}


def rows_of(case: Case, count: int, out: Path, kind: str, measure: Callable[[SetUp], dict[str, Any]]) -> list[Any]:
    """Measure set-ups that are not in the case's file yet, and return all."""
    file = out / f"{case.name.replace(', ', '-').replace(' ', '-')}-{kind}.jsonl"
    known = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    if len(known) < count:
        learned = learned_fold(case, out)
        assert learned.folder is not None
        print(f"{case.name}: {learned.held.headline if learned.held else ''}", flush=True)
        evidence = evidence_of(learned, ObservedFolder(learned.folder), progress=partial(_progress, case.name))
        for seed in range(len(known), count):
            row = measure(SetUp(evidence, seed, case.reality))
            known.append(row)
            with file.open("a") as opened:
                opened.write(json.dumps(row) + "\n")
            print(f"{case.name} {kind} {json.dumps(row)}", flush=True)
    return known[:count]


def _progress(name: str, done: int, total: int) -> None:
    if done % 50 == 0:
        print(f"{name}: {done} of {total} draws", flush=True)


def table(case: Case, rows: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, str]]:
    """Yield the rows of the table of a case: after one observed fold, and after two."""
    for number, plain in ((1, "plain"), (2, "plain 2")):
        before, after, alone = (
            1e3 * np.array([row[name] for row in rows])
            for name in (plain, f"after {number}", "alone" if number == 1 else "alone 2")
        )
        inside = sum(row["inside"][number - 1] for row in rows if len(row["inside"]) >= number)
        total = sum(row["of"] for row in rows if len(row["inside"]) >= number)
        ratio, low, high = _ratio(after, before)
        yield {
            "fold": case.name,
            "set-ups": str(len(rows)),
            "observed": str(number),
            "uncorrected [mm]": f"{np.median(before):.1f}",
            "corrected [mm]": f"{np.median(after):.1f}",
            "random alone [mm]": f"{np.median(alone):.1f}",
            "ratio of medians": f"{ratio:.2f} ({low:.2f} to {high:.2f})",
            "no worse": f"{(after <= before + 1e3 * SLACK).mean():.0%}".replace("%", " %"),
            "inside 90 % intervals": f"{inside / max(total, 1):.0%}".replace("%", " %"),
            "left out": str(sum(row[f"implausible {number}"] for row in rows)),
        }


def _ratio(after: np.ndarray, before: np.ndarray) -> tuple[float, float, float]:
    """Return the ratio of medians and its 90 % interval, by bootstrap."""
    generator = np.random.default_rng(0)
    chosen = generator.integers(0, len(after), (2000, len(after)))
    ratios = np.median(after[chosen], axis=1) / np.median(before[chosen], axis=1)
    low, high = np.quantile(ratios, (0.05, 0.95))
    return float(np.median(after) / np.median(before)), float(low), float(high)


def update_table(rows: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, str]]:
    """Yield a row for each update."""
    plain = 1e3 * np.array([row["none"] for row in rows])
    for name in UPDATES:
        after = 1e3 * np.array([row[name] for row in rows])
        ratio, low, high = _ratio(after, plain)
        yield {
            "update": name,
            "uncorrected [mm]": f"{np.median(plain):.1f}",
            "corrected [mm]": f"{np.median(after):.1f}",
            "ratio of medians": f"{ratio:.2f} ({low:.2f} to {high:.2f})",
            "no worse": f"{(after <= plain + 1e3 * SLACK).mean():.0%}".replace("%", " %"),
            "worst [mm]": f"{after.max():.0f}",
        }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/loop-closed"))
    parser.add_argument("--cases", nargs="+", choices=[case.name for case in CASES])
    parser.add_argument("--set-ups", type=int, help="at most so many of each case")
    parser.add_argument("--tried", type=int, default=CASES[0].set_ups, help="set-ups in which updates are compared")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    lines: list[dict[str, str]] = []
    for case in CASES:
        if options.cases is None or case.name in options.cases:
            count = min(case.set_ups, options.set_ups or case.set_ups)
            lines += table(case, rows_of(case, count, options.out, "folds", run))
    tried = list(update_table(rows_of(CASES[0], options.tried, options.out, "updates", updates)))
    print(markdown(lines), markdown(tried), sep="\n\n", flush=True)
    if options.write_docs:
        publish("loop closed", markdown(lines))
        publish("loop closed: updates", markdown(tried))


if __name__ == "__main__":
    main()
