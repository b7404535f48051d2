"""Hidden set-ups that are observed and corrected: the first tables of docs/notes/observation.md.

    python -m benchmarks.loop_closed [--out FOLDER] [--cases towel ..] [--set-ups N] [--write-docs]

A fold is carried out by a simulator and measured, the next folds are corrected, one of them is measured, and the next
are corrected again. Every set-up is kept; to resume, repeat the command.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from shutil import copytree
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.hidden import CASES, Case, Row, SetUp, Shifts, measured_rows
from benchmarks.tables import markdown, publish
from benchmarks.times import timed
from tatamu.after.feedback.correction import find_correction
from tatamu.after.feedback.posterior import Fold, posterior
from tatamu.simulation.side_by_side import processors

NEXT = 3
"""Next folds of each set-up, which differ in their random parts; the same after no, one and two observations."""
SLACK = 5e-4
"""A set-up is no worse if its next folds end this much farther off at most, in the mean [m]."""


def run(set_up: SetUp) -> Row:
    """Observe and correct one set-up twice."""
    same = set_up.systematic
    random = [set_up.random(10 + number) for number in range(NEXT)]
    row: Row = {
        "before": [set_up.distance(same + new) for new in random],
        "alone": [set_up.distance(new) for new in random],
    }
    folds: list[Fold] = []
    shift: Shifts = ()
    for number in (1, 2):
        folds += set_up.observed(number, shift)
        shift, row[f"inside {number}"] = correction(set_up, folds) if folds else ((), [])
        row[f"after {number}"] = [set_up.distance(same + new, shift) for new in random]
    return row


def correction(set_up: SetUp, folds: Sequence[Fold]) -> tuple[Shifts, list[bool]]:
    """Return the correction after observed folds, and which systematic parts lie in their 90 % intervals."""
    evidence = set_up.evidence
    found = posterior(evidence.disturbances, folds)
    shifts = find_correction(found, evidence.emulator, evidence.base.task.fold, evidence.base.manipulation).shifts
    if not found.used:
        return shifts, []
    low, high = np.quantile(found.members, (0.05, 0.95), axis=0)
    inside = (low <= set_up.systematic) & (set_up.systematic <= high)
    return shifts, inside[np.diag(found.prior.systematic) > 0].tolist()


def table(case: Case, rows: Sequence[Row]) -> Iterator[dict[str, str]]:
    """Yield a row of the table for one and for two observed folds."""
    before, alone = (1e3 * np.array([row[name] for row in rows]) for name in ("before", "alone"))
    for number in (1, 2):
        after = 1e3 * np.array([row[f"after {number}"] for row in rows])
        inside = [each for row in rows for each in row[f"inside {number}"]]
        worse = after.mean(axis=1) > before.mean(axis=1) + 1e3 * SLACK
        yield {
            "fold": case.name,
            "set-ups": str(len(rows)),
            "observed": str(number),
            "uncorrected [mm]": f"{np.median(before):.1f}",
            "corrected [mm]": f"{np.median(after):.1f}",
            "random alone [mm]": f"{np.median(alone):.1f}",
            "ratio of medians": ratio(after, before),
            "to random alone": ratio(after, alone),
            "no worse": f"{100 * (1 - worse.mean()):.0f} %",
            "inside 90 % intervals": f"{100 * np.mean(inside):.0f} %" if inside else "",
            "left out": str(sum(not row[f"inside {number}"] for row in rows)),
        }


def ratio(after: np.ndarray, before: np.ndarray) -> str:
    """Return the ratio of medians and its 90 % interval, by bootstrap of set-ups, shape (set-ups, next folds)."""
    chosen = np.random.default_rng(0).integers(0, len(after), (2000, len(after)))
    ratios = np.median(after[chosen], axis=(1, 2)) / np.median(before[chosen], axis=(1, 2))
    low, high = np.quantile(ratios, (0.05, 0.95))
    return f"{np.median(after) / np.median(before):.2f} ({low:.2f} to {high:.2f})"


def least_time(words: Sequence[str], times: int) -> float:
    """Run a command several times, and return the least of its processor times [s]."""
    return min(timed([sys.executable, "-m", "tatamu", *words]).processor for _ in range(times))


def timed_commands(learned: Path) -> Iterator[dict[str, str]]:
    """Yield the processor times of the commands on a fold whose draws are there, and as multiples of the start."""
    start = least_time(["--version"], 3)
    with TemporaryDirectory() as folder:
        copy = str(copytree(learned, Path(folder) / "towel"))
        commands = {
            "observe": (["observe", copy, "--left", "20,-3", "--right", "22,4", "--slip", "2,0"], 3),
            "correct": (["correct", copy], 3),
            "learn --after": (["learn", "--after", copy, "--out", str(Path(folder) / "next")], 1),
        }
        for name, (words, times) in commands.items():
            seconds = least_time(words, times)
            yield {
                "command": f"`tatamu {name}`",
                "processor seconds": f"{seconds:.1f}",
                "times `tatamu --version`": f"{seconds / start:.0f}",
            }


def main() -> None:
    """Measure, print, and put the tables into their page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/loop-closed"))
    parser.add_argument("--cases", nargs="+", choices=[case.name for case in CASES])
    parser.add_argument("--set-ups", type=int, help="at most so many of each case")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    lines: list[dict[str, str]] = []
    for case in CASES:
        if options.cases is None or case.name in options.cases:
            count = min(case.set_ups, options.set_ups or case.set_ups)
            rows = measured_rows(case, count, options.out, "folds", run, processors())
            lines += table(case, rows)
    times = markdown(list(timed_commands(options.out / "towel")))
    print(markdown(lines), times, sep="\n\n", flush=True)
    if options.write_docs:
        publish("loop closed", markdown(lines))
        publish("loop closed: commands", times)


if __name__ == "__main__":
    main()
