"""Compares simulators over a set of manipulations.

A manipulation is the motion of the hands in a fold. Two simulators agree well if they order the manipulations in the
same way, and if the final shapes of the cloth are similar. Every simulation is stored, so an interrupted comparison can
be resumed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from tatamu.after.second_opinion.check import modify_scene
from tatamu.base.errors import InputError, SimulationError, WorkerKilledError
from tatamu.base.version import __version__
from tatamu.evaluation.nominal import penalty
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import Score, score
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.mesh.subdivision import on_coarse_mesh
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import named
from tatamu.study.result import Result

LEARNED = "learned"


@dataclass(frozen=True)
class Entry:
    """The result of a manipulation (the motion of the hands in a fold) in a simulator."""

    manipulation: str
    simulator: str
    objective: float
    """Objective C of the fold, or a penalty if the simulation failed."""
    score: Score | None
    final: np.ndarray | None
    """Final positions of the cloth's vertices [m], shape (n, 3); None if the simulation failed."""
    error: str | None

    def distance_to(self, other: Entry) -> float | None:
        """Return the mean distance between the final vertices of two results [m].

        The result is None if one of the simulations failed.
        """
        if self.final is None or other.final is None:
            return None
        return float(np.linalg.norm(self.final - other.final, axis=1).mean())


@dataclass(frozen=True)
class Pair:
    """The comparison of two simulators over a set of manipulations, the motions of the hands in a fold."""

    first: str
    second: str
    objective_rank: float
    """Spearman's rank correlation between the objectives C of the manipulations in one simulator and in the other."""
    distance_rank: float
    """Spearman's rank correlation between the mean vertex distances in one simulator and in the other.

    The mean vertex distance of a manipulation is the mean distance of the vertices from their targets. Unlike the
    objective C, this distance does not contain the length of the hands' paths, which is equal in both simulators."""
    between: dict[str, float]
    """Mean distance between the final vertices in both simulators [m], for each manipulation that finished in both
    simulators.
    """

    @property
    def mean_between(self) -> float | None:
        """Mean of `between` over the manipulations [m]; None if no manipulation finished in both simulators."""
        return float(np.mean(list(self.between.values()))) if self.between else None

    @property
    def median_between(self) -> float | None:
        """Median of `between` over the manipulations [m]; None if no manipulation finished in both simulators."""
        return float(np.median(list(self.between.values()))) if self.between else None


@dataclass(frozen=True)
class Agreement:
    """All results of a comparison of simulators."""

    learned: Result
    simulators: list[str]
    manipulations: list[str]
    entries: dict[tuple[str, str], Entry]
    """Results of all simulations, by the names of the manipulation and the simulator."""

    @property
    def pairs(self) -> list[Pair]:
        """Comparisons of all pairs of simulators."""
        return [self._pair(first, second) for first, second in combinations(self.simulators, 2)]

    def _pair(self, first: str, second: str) -> Pair:
        ours, theirs = self.column(first), self.column(second)
        between = {a.manipulation: d for a, b in zip(ours, theirs, strict=True) if (d := a.distance_to(b)) is not None}
        finished = [(a.score, b.score) for a, b in zip(ours, theirs, strict=True) if a.score and b.score]
        return Pair(
            first,
            second,
            rank_correlation([a.objective for a in ours], [b.objective for b in theirs]),
            rank_correlation(*([s[k].mean_vertex_distance for s in finished] for k in (0, 1))),
            between,
        )

    def column(self, simulator: str) -> list[Entry]:
        """Return the results of all manipulations in one simulator."""
        return [self.entries[name, simulator] for name in self.manipulations]

    @property
    def holds(self) -> bool:
        """Whether the learned fold meets the thresholds of success in every simulator."""
        entries = [self.entries[LEARNED, simulator] for simulator in self.simulators]
        return all(entry.score is not None and entry.score.succeeds for entry in entries)

    def to_json(self) -> dict[str, Any]:
        """Return the results as a dictionary for the file `agreement.json`."""
        return {
            "version": 1,
            "tatamu": __version__,
            "garment": self.learned.record.task.garment,
            "fold": self.learned.record.task.fold,
            "learned_in": self.learned.simulator,
            "holds": self.holds,
            "pairs": [_pair_data(pair) for pair in self.pairs],
            "manipulations": [_entry_data(self.entries[n, s]) for n in self.manipulations for s in self.simulators],
        }


def rank_correlation(first: list[float], second: list[float]) -> float:
    """Return Spearman's rank correlation of two lists.

    The result is NaN if there are fewer than three values, or if one of the lists is constant.
    """
    if len(first) < 3 or len(set(first)) == 1 or len(set(second)) == 1:
        return float("nan")
    return float(spearmanr(first, second).statistic)


def _pair_data(pair: Pair) -> dict[str, Any]:
    ranks = {"objective": pair.objective_rank, "mean_vertex_distance": pair.distance_rank}
    return {
        "simulators": [pair.first, pair.second],
        "rank_correlation": {name: rank if np.isfinite(rank) else None for name, rank in ranks.items()},
        "distance_between_final_shapes": {"mean": pair.mean_between, "median": pair.median_between, **pair.between},
    }


def _entry_data(entry: Entry) -> dict[str, Any]:
    measures = entry.score.model_dump() if entry.score else None
    return {
        "manipulation": entry.manipulation,
        "simulator": entry.simulator,
        "objective": entry.objective,
        "score": measures,
        "error": entry.error,
    }


def manipulations(learned: Result, count: int, seed: int) -> dict[str, tuple[Scene, float]]:
    """Return the manipulations to compare, by name: the learned fold, fixed trajectories and random manipulations.

    Each manipulation has a scene and its trajectory length l_x, the mean length of the hands' paths [m]. The number of
    random manipulations is `count`.
    """
    fold = learned.task.fold
    length = learned.score.trajectory_length
    made = {name: make(fold) for name, (_, make) in BASELINES.items()}
    made |= {f"random-{number}": drawn for number, drawn in enumerate(_random(learned, count, seed))}
    scenes = {name: (scene_of(fold, drawn), drawn.trajectory_length) for name, drawn in made.items()}
    return {LEARNED: (learned.scene, length), **scenes}


def _random(learned: Result, count: int, seed: int) -> Iterator[Manipulation]:
    """Yield random manipulations with a uniform distribution over the search space."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        drawn = {
            name: float(random.integers(int(among.low), int(among.high), endpoint=True))
            if among.whole
            else float(random.uniform(among.low, among.high))
            for name, among in learned.task.space.bounds.items()
        }
        yield learned.task.manipulation(drawn)


def compare(
    learned: Result,
    simulators: list[str],
    folder: Path,
    *,
    count: int = 10,
    seed: int = 0,
    halved: bool = False,
    progress: Callable[[str, str], None] = lambda manipulation, simulator: None,
    executor: Executor | None = None,
) -> Agreement:
    """Simulate a set of manipulations in several simulators.

    Args:
        learned: Learned fold; all manipulations are for its task.
        simulators: Names of the simulators.
        folder: Folder in which every simulation is kept.
        count: Number of random manipulations.
        seed: Random seed of the random manipulations.
        halved: Whether to simulate on a mesh of half the spacing.
        progress: Function that is called before each simulation. If an executor is given, the function is called before
            the wait for each result.
        executor: Executor to which all simulations are submitted at once; None to run them in this process, one after
            the other.

    Raises:
        InputError: If a simulator does not exist or cannot run here, or the folder cannot be used.
    """
    for simulator in simulators:
        named(simulator)
    if len(simulators) < 2 or len(set(simulators)) < len(simulators):
        raise InputError(f"--simulators: must be two or more different ones, given {', '.join(simulators) or 'none'}")
    made = manipulations(learned, count, seed)
    faces = learned.faces
    runs = [
        _Run(simulator, name, modify_scene(scene, None, halved), folder / "rollouts" / simulator / f"{name}.npz", faces)
        for simulator in simulators
        for name, (scene, _) in made.items()
    ]
    begun = [None if executor is None or run.kept else executor.submit(ends, *run.arguments) for run in runs]
    entries = {}
    for run, future in zip(runs, begun, strict=True):
        progress(run.name, run.simulator)
        rollout = run.rollout(future)
        entries[run.name, run.simulator] = _entry(learned, run.name, run.simulator, made[run.name][1], rollout)
    return Agreement(learned, simulators, list(made), entries)


@dataclass(frozen=True)
class _Run:
    """The simulation of one manipulation in one simulator, and the file that keeps its first and last frame."""

    simulator: str
    name: str
    scene: Scene
    path: Path
    faces: np.ndarray

    @property
    def arguments(self) -> tuple[Scene, str, np.ndarray]:
        """Arguments of the function `ends` for this simulation."""
        return self.scene, self.simulator, self.faces

    @cached_property
    def digest(self) -> str:
        """Digest of the scene."""
        return sha256(self.scene.model_dump_json().encode()).hexdigest()

    @cached_property
    def kept(self) -> Rollout | None:
        """Rollout from the file; None if there is no file, or the file belongs to another scene."""
        if not self.path.exists():
            return None
        rollout = Rollout.load(self.path)
        return rollout if rollout.info.get("scene") == self.digest else None

    def rollout(self, future: Future[Rollout] | None) -> Rollout:
        """Return the first and last frame from the file.

        If the file has no frames of this scene, the scene is simulated, and both frames are written to the file.
        """
        if self.kept is not None:
            return self.kept
        try:
            found = ends(*self.arguments) if future is None else future.result()
        except WorkerKilledError as error:
            found = _without_end(self.scene, self.simulator, self.faces, error)
        named_scene = Rollout(found.times, found.positions, found.faces, {**found.info, "scene": self.digest})
        named_scene.save(self.path)
        return named_scene


def ends(scene: Scene, simulator: str, faces: np.ndarray) -> Rollout:
    """Simulate a scene, and return the first and last frame at the vertices of the mesh `faces`.

    The mesh of the scene is this mesh, or a subdivision of it.

    If the simulation fails, the result contains the first frame twice, and the error.
    """
    try:
        rollout = on_coarse_mesh(named(simulator).simulate(scene), faces)
    except SimulationError as error:
        return _without_end(scene, simulator, faces, error)
    return Rollout(rollout.times[[0, -1]], rollout.positions[[0, -1]], faces, rollout.info)


def _without_end(scene: Scene, simulator: str, faces: np.ndarray, error: SimulationError) -> Rollout:
    start = scene.cloth.vertices[: faces.max() + 1]
    return Rollout(np.zeros(2), np.stack([start, start]), faces, {"simulator": simulator, "error": str(error)})


def _entry(learned: Result, name: str, simulator: str, length: float, rollout: Rollout) -> Entry:
    error = rollout.info.get("error")
    if error is not None:
        return Entry(name, simulator, penalty(learned.task.fold, length), None, None, error)
    final = rollout.positions[-1]
    reached = score(learned.task.fold, length, final)
    return Entry(name, simulator, reached.objective, reached, final, None)
