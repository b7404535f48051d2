"""How far simulators agree over folds of one towel: docs/notes/second-opinion.md.

    python -m benchmarks.crosscheck --out runs/crosscheck [--simulators native,mujoco] [--only towel]
    python -m benchmarks.crosscheck --out runs/agreement --fold runs/towel

Every simulation is kept in --out. To resume an interrupted run, run the same command again.
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import spearmanr

from benchmarks.tables import arguments, show
from tatamu.after.second_opinion.check import modify_scene
from tatamu.api import learn
from tatamu.base.errors import SimulationError
from tatamu.evaluation.nominal import failed
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import Score, score
from tatamu.folding.task import Task, make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.mesh.meshing import before_subdivision
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

PARTS = {"small": {"size": (0.20, 0.40), "spacing": 0.015}, "towel": {}}
"""The two towels. The mesh of the small towel is fine enough for the bending of MuJoCo."""
LEARNED = "learned"
HALVED = "native, half the spacing"


class Entry(NamedTuple):
    """A manipulation in one simulator."""

    objective: float
    """C, or the penalty of a failed trial."""
    score: Score | None
    final: np.ndarray | None
    """Final positions [m], shape (n, 3); None after a failure."""


Column = dict[str, Entry]
"""The entries of a simulator, by manipulation."""


def manipulations(learned: Result, count: int) -> dict[str, tuple[Scene, float]]:
    """Return scenes and lengths of the hands' paths [m]: the learned fold, hand-designed curves and random folds."""
    fold = learned.task.fold
    made = {name: make(fold) for name, (_, make) in BASELINES.items()}
    random = np.random.default_rng(0)
    made |= {f"random-{index}": draw(learned.task, random) for index in range(count)}
    scenes = {name: (scene_of(fold, each), each.trajectory_length) for name, each in made.items()}
    return {LEARNED: (learned.scene, learned.score.trajectory_length), **scenes}


def draw(task: Task, random: np.random.Generator) -> Manipulation:
    """Return a manipulation that is uniformly distributed over the search space."""
    return task.manipulation(
        {
            name: float(random.integers(int(among.low), int(among.high), endpoint=True))
            if among.whole
            else float(random.uniform(among.low, among.high))
            for name, among in task.space.bounds.items()
        }
    )


def compare(learned: Result, simulators: list[str], folder: Path, count: int) -> dict[str, Column]:
    """Return the column of each simulator; `HALVED` stands for `native` on a finer mesh."""
    made = manipulations(learned, count)
    return {
        simulator: {
            name: entry(learned, final(learned, scene, simulator, folder / simulator / f"{name}.npy"), length)
            for name, (scene, length) in made.items()
        }
        for simulator in simulators
    }


def final(learned: Result, scene: Scene, simulator: str, path: Path) -> np.ndarray | None:
    """Return the final positions from the file, which is empty after a failure, or simulate the scene."""
    if not path.exists():
        print(f"{path.stem} in {simulator}", flush=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        halved = simulator == HALVED
        try:
            rollout = simulate(modify_scene(scene, None, halved), "native" if halved else simulator)
            found = before_subdivision(rollout, learned.faces).positions[-1]
        except SimulationError:
            found = np.empty((0, 3))
        np.save(path, found)
    kept = np.load(path)
    return kept if len(kept) else None


def entry(learned: Result, end: np.ndarray | None, length: float) -> Entry:
    if end is None:
        return Entry(failed(learned.task.fold, length, "failed").objective, None, None)
    reached = score(learned.task.fold, length, end)
    return Entry(reached.objective, reached, end)


def pair(columns: dict[str, Column], first: str, second: str) -> dict[str, str]:
    """Return the row that compares two simulators."""
    both = {name: (columns[first][name], columns[second][name]) for name in columns[first]}
    finished = {name: (a, b) for name, (a, b) in both.items() if a.score and b.score}
    apart = {
        name: 1e3 * float(np.linalg.norm(a.final - b.final, axis=1).mean())  # type: ignore[operator]
        for name, (a, b) in finished.items()
    }
    distances = [(a.score.mean_vertex_distance, b.score.mean_vertex_distance) for a, b in finished.values()]  # type: ignore[union-attr]
    return {
        "simulators": f"{first}, {second}",
        "rank of C": f"{spearmanr([(a.objective, b.objective) for a, b in both.values()]).statistic:.2f}",
        "rank of mean distance": f"{spearmanr(distances).statistic:.2f}",
        "mean [mm]": f"{np.mean(list(apart.values())):.1f}",
        "median [mm]": f"{np.median(list(apart.values())):.1f}",
        "learned [mm]": f"{apart[LEARNED]:.1f}" if LEARNED in apart else "–",
    }


def distances(columns: dict[str, Column]) -> list[dict[str, str]]:
    """Return the mean vertex distance of each manipulation in each simulator."""
    names = next(iter(columns.values()))
    return [{"manipulation": name, **{who: _millimetres(own[name]) for who, own in columns.items()}} for name in names]


def _millimetres(found: Entry) -> str:
    return f"{1e3 * found.score.mean_vertex_distance:.1f}" if found.score else "failed"


def tables(columns: dict[str, Column], simulators: list[str], part: str) -> dict[str, list[dict[str, str]]]:
    """Return the table of pairs of simulators, and that of manipulations, by their marks in the docs."""
    pairs = [pair(columns, *two) for two in combinations(simulators, 2)]
    return {f"agreement: {part}": pairs, f"agreement: {part}, each": distances(columns)}


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--simulators", default="native,blender,mujoco")
    parser.add_argument("--random", type=int, default=10)
    parser.add_argument("--fold", type=Path, metavar="DIR", help="a learned fold in place of the two towels")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    options = parser.parse_args()
    names = options.simulators.split(",")
    if options.fold:
        columns = compare(Result.load(options.fold), names, options.out, options.random)
        show(tables(columns, names, "fold"), write=False)
        return
    for part in options.only:
        size: Any = PARTS[part]
        folder = options.out / part
        settings = LearnOptions(trials=15, seed=0, disturbances="none")
        learn(make_task("towel", **size), settings, out=folder / "towel")
        learned = Result.load(folder / "towel")
        finer = [HALVED] if part == "small" else []
        columns = compare(learned, [*names, *finer], folder / "agreement", options.random)
        show(tables(columns, names, part), options.write_docs)


if __name__ == "__main__":
    main()
