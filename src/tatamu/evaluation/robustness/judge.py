"""Simulates a fold in many worlds, on one mesh or on two meshes. Every result is kept.

A world is one random draw of all disturbances, and a verdict is the result of the fold in one world.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, field

from tatamu.base.errors import WorkerKilledError
from tatamu.evaluation import Evaluator
from tatamu.evaluation.disturbances import NOMINAL, World, hand_failure
from tatamu.evaluation.robustness.cache import VerdictCache
from tatamu.evaluation.robustness.meshes import FoldOnMesh, MeshVerdict, SlackRange, select_pairs
from tatamu.evaluation.robustness.verdict import Verdict
from tatamu.folding.score import Limits

Progress = Callable[[int, int], None]
"""Callback with two numbers: simulations that have ended, and simulations that are known to be necessary."""
WorldSearch = Generator[World, Verdict, float | None]
"""A generator that yields worlds (draws of the disturbances), receives their verdicts, and returns its result."""


@dataclass(frozen=True)
class Judged:
    """Verdicts that a simulation on the fine mesh would not change.

    A world is one random draw of all disturbances, and a verdict is the result of the fold in one world.
    """

    nominal: MeshVerdict
    worlds: list[MeshVerdict]
    """Verdicts on the given worlds (draws of the disturbances), in the order of the worlds."""
    findings: list[float | None]
    """Results of the searches (see `WorldSearch`), in the order in which the searches were given."""
    seen: list[MeshVerdict]
    """Verdicts on all simulated worlds (draws of the disturbances), including those that the searches requested."""


@dataclass
class _Mesh:
    """A fold on one mesh, and the worlds (draws of the disturbances) in which it was simulated."""

    fold: FoldOnMesh
    requested: set[str] = field(default_factory=set)
    """Keys of the simulations that were needed, including those whose results were in the cache."""

    def __post_init__(self) -> None:
        self.name = self.fold.key

    def key(self, world: World) -> str:
        return VerdictCache.key(self.name, world)


class Judge:
    """Simulates a fold in worlds (draws of the disturbances) on the coarse mesh.

    The simulation is repeated on the fine mesh if this could change the verdict, the result in this world.
    """

    def __init__(
        self,
        fine: FoldOnMesh,
        coarse: FoldOnMesh | None,
        workers: Executor,
        cache: VerdictCache,
        progress: Progress = lambda done, total: None,
    ) -> None:
        """Prepare simulations of a fold on one mesh or on two meshes.

        Args:
            fine: The fold on the fine mesh.
            coarse: The same fold on a coarser mesh; None if only the fine mesh is simulated.
            workers: Executor that runs the simulations.
            cache: Results of earlier simulations. New results are added.
            progress: Function that is called after every simulation.
        """
        self._fine = _Mesh(fine)
        self._coarse = None if coarse is None else _Mesh(coarse)
        self._workers = workers
        self._cache = cache
        self._progress = progress
        self._ended = 0

    @property
    def simulations(self) -> int:
        """Number of simulations on both meshes. Results from the cache are counted."""
        return self.fine_simulations + (len(self._coarse.requested) if self._coarse else 0)

    @property
    def fine_simulations(self) -> int:
        """Number of simulations on the fine mesh."""
        return len(self._fine.requested)

    def judge(
        self,
        worlds: Sequence[World],
        limits: Limits,
        searches: Callable[[], list[WorldSearch]] = list,
        nominal: World = NOMINAL,
    ) -> Judged:
        """Simulate the fold in the given worlds, in the nominal world, and in the worlds that the searches request.

        A world is one random draw of all disturbances. A verdict is the result of the fold in one world. Every world is
        simulated on the coarse mesh. If its verdict is not final, it is also simulated on the fine mesh.

        Args:
            worlds: Worlds in which the fold is simulated.
            limits: Limits of a successful fold.
            searches: Function that starts the searches. It is called again whenever more is known about the differences
                between the meshes.
            nominal: World without disturbances. If the disturbances have means that are not zero, it is the world in
                which every disturbance has its mean.
        """
        everything = [nominal, *worlds]
        slack = SlackRange(limits)
        if self._coarse is not None:
            rough = [one.verdict for one in self._judge(everything, slack)[1:]]
            sample = [nominal, *(worlds[number] for number in select_pairs(rough, limits))]
            slack = slack.including(self._judge(sample, SlackRange.unbounded(limits)))
        while True:
            centre, *found = self._judge(everything, slack)
            findings, others = self._follow(searches(), slack)
            seen = [centre, *found, *others]
            wider = slack.including(seen)
            if wider == slack:
                return Judged(centre, found, findings, seen)
            slack = wider

    def _follow(
        self, searches: Sequence[WorldSearch], slack: SlackRange
    ) -> tuple[list[float | None], list[MeshVerdict]]:
        """Run all searches to their ends, and return their results and all verdicts on the fold.

        A world is one random draw of all disturbances. A verdict is the result of the fold in one world. A search is a
        generator. Each time that it yields a world, the fold is simulated in this world, and the search receives the
        verdict.
        """
        findings: list[float | None] = [None] * len(searches)
        seen: list[MeshVerdict] = []
        wanted = {number: next(search) for number, search in enumerate(searches)}
        while wanted:
            judged = self._judge(list(wanted.values()), slack)
            seen += judged
            numbers, wanted = list(wanted), {}
            for number, one in zip(numbers, judged, strict=True):
                try:
                    wanted[number] = searches[number].send(one.verdict)
                except StopIteration as stop:
                    findings[number] = stop.value
        return findings, seen

    def _judge(self, worlds: Sequence[World], slack: SlackRange) -> list[MeshVerdict]:
        """Simulate the fold in worlds (draws of the disturbances), and return its verdicts.

        The coarse mesh is simulated first, and the fine mesh if the coarse verdict is not final.
        """
        if self._coarse is None:
            return [MeshVerdict(verdict) for verdict in self._simulate(self._fine, worlds)]
        coarse = self._simulate(self._coarse, worlds)
        settled = [
            slack.is_conclusive(verdict) and self._fine.key(world) not in self._fine.requested
            for world, verdict in zip(worlds, coarse, strict=True)
        ]
        open_worlds = [world for world, done in zip(worlds, settled, strict=True) if not done]
        fine = iter(self._simulate(self._fine, open_worlds))
        return [
            MeshVerdict(verdict, verdict, fine=False) if done else MeshVerdict(next(fine), verdict)
            for verdict, done in zip(coarse, settled, strict=True)
        ]

    def _simulate(self, mesh: _Mesh, worlds: Sequence[World]) -> list[Verdict]:
        """Return the results of the fold in worlds (draws of the disturbances) on one mesh.

        Known results are not simulated again.
        """
        keys = [mesh.key(world) for world in worlds]
        mesh.requested.update(keys)
        missing = {key: world for key, world in zip(keys, worlds, strict=True) if self._cache.get(key) is None}
        jobs = {key: (mesh.fold, world) for key, world in missing.items()}
        simulate_missing(
            jobs, self._workers, self._cache, lambda left: self._progress(self.simulations - left, self.simulations)
        )
        return [verdict for key in keys if (verdict := self._cache.get(key)) is not None]


def simulate_missing(
    jobs: Mapping[str, tuple[FoldOnMesh, World]],
    workers: Executor,
    cache: VerdictCache,
    ended: Callable[[int], None],
) -> None:
    """Simulate folds in worlds (draws of the disturbances), and keep each verdict immediately.

    Args:
        jobs: Fold and world for each key of the cache.
        workers: Executor that runs the simulations.
        cache: Cache that keeps the verdicts.
        ended: Function that is called after every simulation with the number of remaining simulations.
    """
    futures = {
        workers.submit(verdict_in, fold.evaluator, fold.parameters, world): key for key, (fold, world) in jobs.items()
    }
    try:
        for left, future in zip(range(len(futures) - 1, -1, -1), as_completed(futures), strict=True):
            cache.keep(futures[future], _result(future))
            ended(left)
    finally:
        for future in futures:
            future.cancel()  # only has an effect after an interruption


def verdict_in(evaluator: Evaluator, parameters: Mapping[str, int | float], world: World) -> Verdict:
    """Simulate a manipulation in a world, which is one draw of the disturbances.

    There is no simulation if a hand misses the cloth in this world, or if a hand must stop because it is too low.
    """
    task = evaluator.task
    failure = hand_failure(task.fold, task.manipulation(parameters), world)
    if failure is not None:
        return Verdict(None, None, failure)
    return Verdict.of(evaluator.in_world(parameters, world), task.fold)


def _result(future: Future[Verdict]) -> Verdict:
    """Return the verdict of a simulation. If the simulation killed its processes, the verdict is a failure."""
    try:
        return future.result()
    except WorkerKilledError as error:
        return Verdict(None, None, str(error))
