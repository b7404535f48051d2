"""Updates that were tried for observed folds: the second table of docs/notes/observation.md.

    python -m benchmarks.updates [--out FOLDER] [--set-ups N] [--write-docs]

Hidden set-ups of the towel (`benchmarks.hidden`) are corrected after one observed fold by each update.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from unittest.mock import patch

import numpy as np

from benchmarks.hidden import RULER, TOWEL, Row, SetUp, Shifts, measured_rows
from benchmarks.loop_closed import SLACK, ratio
from benchmarks.tables import markdown, publish
from tatamu.after.feedback.correction import CORRECTABLE, find_correction, shift_against
from tatamu.after.feedback.draws import USUAL
from tatamu.after.feedback.observe import Evidence, emulator_of
from tatamu.after.feedback.posterior import Fold, posterior
from tatamu.evaluation.disturbances import World, hand_errors, split
from tatamu.folding.marks import MARKS

NEXT = 2
"""Next folds of each set-up."""
FEWEST_EFFECTIVE = 20
"""Number of effective draws to which importance weights are tempered."""


def tempered(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct as tatamu does."""
    found = posterior(evidence.disturbances, [fold])
    return find_correction(found, fold.emulator, evidence.base.task.fold, evidence.base.manipulation).shifts


def without_width(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct as tatamu does, with deviations taken as they are stated."""
    with patch("tatamu.after.feedback.posterior.WIDTH", 0.0):
        return tempered(evidence, fold)


def linear(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct as tatamu does, on an emulator that does not know which hand opens last, nor what taut cloth does."""
    with patch("tatamu.after.feedback.emulator.FOLLOWS", 1e6), patch("tatamu.after.feedback.emulator.APART", 1e6):
        emulator = emulator_of(evidence.base, evidence.disturbances, evidence.draws)
        return tempered(evidence, Fold(fold.observation, emulator, fold.correction))


def ensemble(evidence: Evidence) -> tuple[np.ndarray, np.ndarray]:
    """Return the systematic parts (n, k) of the usual draws, drawn given their sum, and their marks (n, m)."""
    parts = split(evidence.disturbances)
    generator = np.random.default_rng(0)
    share = np.diag(parts.systematic) / np.maximum(parts.deviations**2, 1e-30)
    deviation = np.sqrt(share * (1.0 - share)) * parts.deviations
    rows, seen = [], []
    for world, verdict in evidence.draws.worlds[1 : 1 + USUAL]:
        if verdict.marks is None:
            continue
        values = np.array([world[name] for name in parts.names])
        rows.append(parts.mean + share * (values - parts.mean) + deviation * generator.standard_normal(len(values)))
        seen.append([verdict.marks[name] for name in MARKS])
    return np.array(rows), np.array(seen) + evidence.draws.difference


def kalman(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct by a plain ensemble Kalman update of the draws."""
    members, seen = ensemble(evidence)
    seen = seen[:, fold.places]
    centred = seen - seen.mean(axis=0)
    noise = len(seen) * RULER**2 * np.eye(seen.shape[1])
    gain = (members - members.mean(axis=0)).T @ centred @ np.linalg.inv(centred.T @ centred + noise)
    return _against(evidence, members.mean(axis=0) + gain @ (fold.values - seen.mean(axis=0)))


def weighted(evidence: Evidence, fold: Fold) -> Shifts:
    """Correct by importance weights of the draws, tempered until enough of them are effective."""
    members, seen = ensemble(evidence)
    squared = ((seen[:, fold.places] - fold.values) ** 2).sum(axis=1) / RULER**2
    for power in np.geomspace(1.0, 1e-6, 60):
        weights = np.exp(-0.5 * power * (squared - squared.min()))
        weights /= weights.sum()
        if 1.0 / (weights**2).sum() >= FEWEST_EFFECTIVE:
            break
    return _against(evidence, weights @ members)


def _against(evidence: Evidence, mean: np.ndarray) -> Shifts:
    """Return the shift against a mean of the systematic parts."""
    names = split(evidence.disturbances).names
    use = [any(f"{name}.".startswith(f"{part}.") for part in CORRECTABLE) for name in names]
    values = {name: float(value) for name, value, used in zip(names, mean, use, strict=True) if used}
    base = evidence.base
    return shift_against(hand_errors(base.task.fold, base.manipulation, World(values)))


UPDATES: Mapping[str, Callable[[Evidence, Fold], Shifts]] = {
    "tempered, on the emulator": tempered,
    "the same, width as stated": without_width,
    "the same, linear emulator": linear,
    "plain ensemble Kalman": kalman,
    "importance weights of draws": weighted,
}


def run(set_up: SetUp) -> Row:
    """Correct one set-up after one observed fold by each update."""
    same, random = set_up.systematic, [set_up.random(10 + number) for number in range(NEXT)]
    folds = set_up.observed(1)
    row: Row = {"none": [set_up.distance(same + new) for new in random]}
    for name, update in UPDATES.items():
        shift = update(set_up.evidence, folds[0]) if folds else ()
        row[name] = [set_up.distance(same + new, shift) for new in random]
    return row


def table(rows: Sequence[Row]) -> Iterator[dict[str, str]]:
    """Yield a row for each update."""
    plain = 1e3 * np.array([row["none"] for row in rows])
    for name in UPDATES:
        after = 1e3 * np.array([row[name] for row in rows])
        worse = after.mean(axis=1) > plain.mean(axis=1) + 1e3 * SLACK
        yield {
            "update": name,
            "uncorrected [mm]": f"{np.median(plain):.1f}",
            "corrected [mm]": f"{np.median(after):.1f}",
            "ratio of medians": ratio(after, plain),
            "no worse": f"{100 * (1 - worse.mean()):.0f} %",
            "worst [mm]": f"{after.max():.0f}",
        }


def main() -> None:
    """Measure, print, and put the table into its page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/loop-closed"))
    parser.add_argument("--set-ups", type=int, default=12)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows = measured_rows(TOWEL, options.set_ups, options.out, "updates", run, threads=1)  # `patch` is for all threads
    text = markdown(list(table(rows)))
    print(text, flush=True)
    if options.write_docs:
        publish("loop closed: updates", text)


if __name__ == "__main__":
    main()
