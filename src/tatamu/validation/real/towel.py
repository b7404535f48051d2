"""A towel folded in half by robots: Garcia-Camacho et al. 2020, five trials of two TIAGo arms, beside learned folds.

IEEE RA-L 5(2), "Benchmarking Bimanual Cloth Manipulation". Their measure of a fold is the area seen from above,

    E_f = (100 / 0.5) |A_after / A_before - 0.5| %

and it is all that is compared: neither the fabric nor the shape of the folds was published.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.folding.task import make_task
from tatamu.learning import Progress, learn
from tatamu.presentation.chart import Chart, axis, traces
from tatamu.results import ResultFolder
from tatamu.validation.real.bench import Bench
from tatamu.validation.real.columns import Columns
from tatamu.validation.real.section import Line, Section, Tabulated, reached
from tatamu.validation.real.test import RealTest

FILE = "garcia_camacho_2020_towel.csv"
SIZE = (0.5, 1.0)
"""Of their towel [m]."""
TRIALS = 30
"""Of each study."""


@dataclass(frozen=True)
class RobotFold:
    """One trial of the robots."""

    area_error: float
    """E_f [%]; not a number where it failed."""


class Towel(RealTest):
    """E_f of learned folds of a towel of that size."""

    name = "towel"

    def load(self, data: Path) -> list[RobotFold]:
        """See `RealTest.load`."""
        table = Columns.load(data / FILE, ("success", "area_before_cm2", "area_after_cm2"))
        return [_robot_fold(table, row) for row in range(len(table.rows))]

    def simulations(self, measured: list[RobotFold], bench: Bench) -> int:
        """See `RealTest.simulations`."""
        return bench.seeds * TRIALS

    def run(self, measured: list[RobotFold], bench: Bench) -> Section:
        """See `RealTest.run`."""
        ours = [_learned(seed, bench) for seed in range(bench.seeds)]
        theirs = [each.area_error for each in measured if np.isfinite(each.area_error)]
        lines: list[Line] = [
            _line("two TIAGo arms, real towel", f"{len(theirs)} of {len(measured)}", theirs),
            _line(f"learned in {bench.simulator}, undisturbed", f"{len(ours)} of {len(ours)}", ours),
        ]
        return Section(
            name=self.name,
            title="A towel folded in half by robots",
            method=(
                f"A towel of {SIZE[0]:g} x {SIZE[1]:g} m in the default terry, folded in half; the best of {TRIALS} "
                f"trials by the objective C, for {len(ours)} seeds of the search. The simulated hands do exactly what "
                "was planned."
            ),
            tables=[Tabulated("real: towel", lines)],
            beat=f"Garcia-Camacho et al. 2020: {np.mean(theirs):.2f} % in the mean of the folds that succeeded.",
            goal=f"E_f not above theirs in the mean: {reached(float(np.mean(ours)) <= float(np.mean(theirs)))}.",
            silent=(
                "E_f is an area: a fold that is turned or wrinkled may have a small one. Their hands and their camera "
                "err and the simulated ones do not, so that a smaller figure here says little of a real robot; the "
                "fabric of their towel is not stated. No shape of a real fold with contact was found in public data."
            ),
            charts=[_chart(theirs, ours, bench.simulator)],
        )


def _robot_fold(table: Columns, row: int) -> RobotFold:
    if table.number(row, "success") == 0.0:
        return RobotFold(float("nan"))
    part = table.number(row, "area_after_cm2") / table.number(row, "area_before_cm2")
    return RobotFold(100.0 / 0.5 * abs(part - 0.5))


def _learned(seed: int, bench: Bench) -> float:
    """E_f of the best fold of one study [%], learned or gone on with in the bench's folder."""
    folder = bench.folder / f"{bench.version[:12]}-seed-{seed}"
    task = make_task("towel", size=SIZE, simulator=bench.simulator)
    done = 0

    def progress(state: Progress) -> None:
        nonlocal done
        for _ in range(state.done - done):
            bench.tick(f"towel, seed {seed}")
        done = state.done

    learn(task, folder, trials=TRIALS, seed=seed, baselines=False, progress=progress)
    error = ResultFolder(folder).result.best_trial.area_error
    return float("nan") if error is None else error


def _line(name: str, succeeded: str, errors: list[float]) -> Line:
    return {
        "fold": name,
        "succeeded": succeeded,
        "E_f [%]": ", ".join(f"{error:.2f}" for error in errors),
        "mean": f"{np.mean(errors):.2f}",
    }


def _chart(theirs: list[float], ours: list[float], simulator: str) -> Chart:
    lines = [
        {"type": "bar", "name": name, "y": [round(error, 3) for error in errors], "marker": {"color": f"@series-{k}"}}
        for k, (name, errors) in enumerate((("two TIAGo arms", theirs), (simulator, ours)))
    ]
    return Chart(
        "E_f of each fold", traces(lines, xaxis=axis("fold"), yaxis=axis("E_f [%]"), showlegend=True), kind="tall"
    )
