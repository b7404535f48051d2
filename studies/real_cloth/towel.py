"""Compares learned folds of a towel with five trials in which two TIAGo arms folded a towel in half.

The trials are from Garcia-Camacho et al. 2020, "Benchmarking Bimanual Cloth Manipulation", IEEE RA-L 5(2). The authors
compare the areas A of the cloth, seen from above, before and after the fold. The area error is:

    E_f = (100 / 0.5) |A_after / A_before - 0.5| %

Only this error is compared, because the fabric and the shapes of the folds were not published.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.real_cloth.bench import Bench
from studies.real_cloth.columns import Columns
from studies.real_cloth.section import Line, Section, Tabulated, reached
from studies.real_cloth.test import RealTest
from tatamu import LearnOptions, Nominal, Progress, Result, Task, learn, make_task
from tatamu.base.files import read_json, write_json
from tatamu.evaluation.disturbances import Scenario, Stream, default_disturbances, sample_scenarios
from tatamu.show.chart import Chart, axis, traces
from tatamu.simulation.side_by_side import executor_of

FILE = "garcia_camacho_2020_towel.csv"
SIZE = (0.5, 1.0)
"""Width and length of the robots' towel [m]."""
TRIALS = 30
"""Number of trials in the search for each fold of the towel."""
SCENARIOS = 30
"""Number of disturbed simulations of the folds that were learned with an objective. All seeds of the objective together
have this number, in equal parts. In a disturbed simulation, all disturbances have random values."""


@dataclass(frozen=True)
class RobotFold:
    """A trial in which the robots of the publication folded a real towel."""

    area_error: float
    """Area error E_f of the robots' fold [%]; NaN if the trial failed."""


class Towel(RealTest):
    """The test that compares the area errors of the robots' folds and of learned folds of a towel of the same size."""

    name = "towel"

    def load(self, data: Path) -> list[RobotFold]:
        table = Columns.load(data / FILE, ("success", "area_before_cm2", "area_after_cm2"))
        return [_robot_fold(table, row) for row in range(len(table.rows))]

    def simulations(self, measured: list[RobotFold], bench: Bench) -> int:
        return (bench.seeds + 1) * TRIALS + 2 * SCENARIOS

    def run(self, measured: list[RobotFold], bench: Bench) -> Section:
        theirs = [each.area_error for each in measured if np.isfinite(each.area_error)]
        robots = _line("two TIAGo arms, real towel", len(measured), theirs)
        still = _tried("C, undisturbed", False, bench.seeds, bench)
        usual = _tried("C over scenarios", True, 1, bench)
        held = usual.held
        often = len(held) / len(usual.disturbed) >= len(theirs) / len(measured)
        return Section(
            name=self.name,
            title="A towel folded in half by robots",
            method=(
                f"A towel of {SIZE[0]:g} x {SIZE[1]:g} m in the default terry is folded in half, by the best of "
                f"{TRIALS} trials. {bench.seeds} seeds minimise the objective C without disturbances; one minimises "
                "C over scenarios. Without disturbances the simulated hands move exactly as "
                f"planned. Then each fold is simulated in {SCENARIOS} scenarios that no search used, with the default "
                "disturbances of hands, grasps, table and material. A fold succeeds if the mean distance of its "
                "vertices from the target is at most 12.5 mm and the views from above overlap by 0.80. E_f is given "
                "for folds that succeed."
            ),
            tables=[Tabulated("real: towel", [robots, *still.lines, *usual.lines])],
            beat=f"Garcia-Camacho et al. 2020: {np.mean(theirs):.2f} % on average for folds that succeeded.",
            goal=(
                "Over scenarios: E_f under disturbances at most as large as theirs: "
                f"{reached(_mean(held) <= _mean(theirs))}; success at least as often: {reached(often)} "
                f"({len(held)} of {len(usual.disturbed)})."
            ),
            silent=(
                "E_f compares areas, so a fold that is turned or wrinkled may have a small one. The errors of their "
                "hands and camera, the fabric of their towel and their definition of success are not stated. No shape "
                "of a real fold with contact was found in public data."
            ),
            charts=[_chart({"two TIAGo arms": theirs, **still.groups, **usual.groups})],
        )


def _robot_fold(table: Columns, row: int) -> RobotFold:
    if table.number(row, "success") == 0.0:
        return RobotFold(float("nan"))
    part = table.number(row, "area_after_cm2") / table.number(row, "area_before_cm2")
    return RobotFold(100.0 / 0.5 * abs(part - 0.5))


@dataclass(frozen=True)
class Tried:
    """The folds of a towel that were learned with one objective and several random seeds."""

    objective: str
    calm: list[float]
    """Area error E_f of each learned fold in a simulation without disturbances [%]."""
    disturbed: list[tuple[float, bool]]
    """Area error E_f of a learned fold in each disturbed simulation [%], and whether the fold succeeded."""

    @property
    def held(self) -> list[float]:
        """Area errors E_f of the disturbed simulations in which the fold succeeded [%]."""
        return [error for error, holds in self.disturbed if holds]

    @property
    def groups(self) -> dict[str, list[float]]:
        """Area errors E_f without and with disturbances, by the name in the chart [%]."""
        return {f"{self.objective}, undisturbed": self.calm, f"{self.objective}, disturbed": self.held}

    @property
    def lines(self) -> list[Line]:
        """Two lines of the table of area errors: simulations without disturbances, and with disturbances."""
        return [
            _line(f"learned by {self.objective}, undisturbed", len(self.calm), self.calm),
            _line("the same, disturbed", len(self.disturbed), self.held),
        ]


def _tried(objective: str, robust: bool, seeds: int, bench: Bench) -> Tried:
    task = make_task("towel", size=SIZE, simulator=bench.simulator)
    results = [_learn(task, seed, robust, bench) for seed in range(seeds)]
    each = SCENARIOS // seeds
    disturbed = [one for seed, result in enumerate(results) for one in _disturbed(task, result, seed, each, bench)]
    return Tried(objective, [_area_error(result) for result in results], disturbed)


def _learn(task: Task, seed: int, robust: bool, bench: Bench) -> Result:
    """Run or resume a study that learns a fold of the towel, and return its result."""
    how = "robust" if robust else "calm"
    disturbances = "default" if robust else "none"
    options = LearnOptions(trials=TRIALS, seed=seed, baselines=False, disturbances=disturbances)
    done = 0

    def progress(now: Progress) -> None:
        nonlocal done
        for _ in range(now.done - done):
            bench.tick(f"towel, {how}, seed {seed}")
        done = now.done

    folder = bench.folder / f"{bench.version[:12]}-{how}-seed-{seed}"
    result = learn(task, options, out=folder, executor=bench.executor, progress=progress)
    assert isinstance(result, Result)
    return result


def _area_error(result: Result) -> float:
    """Return the area error E_f of the best fold that a study learned [%]; NaN if this fold failed."""
    score = result.best.score
    return float("nan") if score is None else score.area_error


def _disturbed(task: Task, result: Result, seed: int, count: int, bench: Bench) -> list[tuple[float, bool]]:
    """Return E_f [%] and whether the fold succeeds in `count` scenarios, kept in the folder of the fold."""
    assert result.folder is not None
    kept = result.folder / f"disturbed-{count}.json"
    if not kept.exists():
        scenarios = sample_scenarios(default_disturbances(), count, seed, Stream.MARGINS)
        with executor_of(bench.executor, count) as executor:
            submitted = [executor.submit(_ended_in, task, result.best.parameters, scenario) for scenario in scenarios]
            write_json(kept, [each.result() for each in submitted])
    for _ in range(count):
        bench.tick(f"towel, seed {seed}, disturbed")
    return [(float("nan") if error is None else error, holds) for error, holds in read_json(kept)]


def _ended_in(task: Task, parameters: dict[str, int | float], scenario: Scenario) -> tuple[float | None, bool]:
    """Return E_f of a fold in a scenario [%], None if the simulation failed, and whether the fold succeeds."""
    score = Nominal(task).simulate(parameters, scenario).score
    return (None, False) if score is None else (score.area_error, score.succeeds)


def _mean(errors: list[float]) -> float:
    """Return the mean of area errors; without any NaN, which meets no goal."""
    return float(np.mean(errors)) if errors else float("nan")


def _line(name: str, tried: int, errors: list[float]) -> Line:
    return {
        "fold": name,
        "succeeded": f"{len(errors)} of {tried}",
        "E_f, mean [%]": f"{np.mean(errors):.2f}" if errors else "–",
        "least": f"{min(errors):.2f}" if errors else "–",
        "greatest": f"{max(errors):.2f}" if errors else "–",
    }


def _chart(groups: dict[str, list[float]]) -> Chart:
    lines = [
        {
            "mode": "markers",
            "name": name,
            "x": [round(error, 3) for error in errors],
            "y": [name] * len(errors),
            "marker": {"color": f"@series-{place}", "size": 9},
        }
        for place, (name, errors) in enumerate(groups.items())
    ]
    return Chart(
        "E_f of each fold", traces(lines, xaxis=axis("E_f [%]"), yaxis=axis("", autorange="reversed")), kind="tall"
    )
