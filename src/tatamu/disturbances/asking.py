"""Worlds that are simulated anywhere and kept: those of draws, and those that searches ask for one after another."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass

from tatamu.disturbances.memory import Memory
from tatamu.disturbances.meshes import Apart, FoldOnMesh, Judged, sampled
from tatamu.disturbances.verdict import Limits, Verdict, judge
from tatamu.disturbances.world import CALM, World
from tatamu.errors import WorkerKilledError

Progress = Callable[[int, int], None]
"""Called with how many simulations have ended and how many are known to be needed."""
Asking = Generator[World, Verdict, float | None]
"""Yields worlds, is sent how the fold ends in them, and returns what it was to find."""
FORESEEN = 1
"""Worlds that a search is thought to ask for, until it asks for more."""
Then = Callable[[Judged], object]


@dataclass
class _Lane:
    """Worlds that are asked for one after another."""

    search: Asking
    end: float | None = None


class Asker:
    """Simulates worlds on one mesh or on two, and keeps what it learns."""

    def __init__(
        self,
        own: FoldOnMesh,
        coarse: FoldOnMesh | None,
        workers: Executor,
        memory: Memory,
        progress: Progress = lambda done, total: None,
    ) -> None:
        """Make an asker that has not simulated anything.

        Args:
            own: The fold on its own mesh.
            coarse: The same on a coarser one; None: there is none.
            workers: Where simulations run.
            memory: What was simulated before, and where simulations are kept.
            progress: Called after every simulation.
        """
        self._own = _Mesh(own)
        self._coarse = None if coarse is None else _Mesh(coarse)
        self._meshes = [each for each in (self._own, self._coarse) if each is not None]
        self._workers = workers
        self._memory = memory
        self._progress = progress
        self._total = 0
        self._running: dict[Future[Verdict], tuple[_Mesh, str, Callable[[Verdict], object]]] = {}

    @property
    def asked(self) -> int:
        """How many simulations were needed, those that were kept from before among them."""
        return sum(len(each.asked) for each in self._meshes)

    @property
    def asked_of_own(self) -> int:
        """How many of them were on the fold's own mesh."""
        return len(self._own.asked)

    def run(
        self, worlds: Sequence[World], apart: Apart, searches: Sequence[Asking] = ()
    ) -> tuple[list[Judged], list[float | None], list[Judged]]:
        """Judge worlds, and follow searches to their ends.

        Args:
            worlds: Some worlds.
            apart: How far both meshes are apart: what the coarse one leaves undecided is simulated on the own mesh. Not
                used where there is no coarse mesh.
            searches: Which ask for worlds one after another.

        Returns:
            Verdicts of the worlds, what the searches found, and all verdicts of both that are known on two meshes.
        """
        found: dict[int, Judged] = {}
        pairs: list[Judged] = []
        lanes = [_Lane(search) for search in searches]
        self._total = max(self._total, self.asked + len(lanes) * FORESEEN + len(worlds))
        for number, world in enumerate(worlds):
            self._judge(world, apart, pairs, lambda judged, number=number: found.update({number: judged}))  # type: ignore[misc]
        for lane in lanes:
            self._follow(lane, apart, pairs)
        self._finish()
        return [found[number] for number in range(len(worlds))], [lane.end for lane in lanes], pairs

    @property
    def two_meshes(self) -> bool:
        """Whether there is a coarse mesh beside the fold's own."""
        return self._coarse is not None

    def _follow(self, lane: _Lane, apart: Apart, pairs: list[Judged], judged: Judged | None = None) -> None:
        """Ask for the next world of a search."""
        try:
            world = next(lane.search) if judged is None else lane.search.send(judged.verdict)
        except StopIteration as stop:
            lane.end = stop.value
            return
        self._judge(world, apart, pairs, lambda judged: self._follow(lane, apart, pairs, judged))

    def _judge(self, world: World, apart: Apart, pairs: list[Judged], then: Then) -> None:
        """Simulate a world on the coarse mesh, and on the own one where that is needed; then hand on its verdict."""
        if self._coarse is None:
            self._simulate(self._own, world, lambda verdict: then(Judged(verdict)))
            return

        def settle(coarse: Verdict) -> None:
            if apart.decides(coarse) and not self._own.has(world):
                then(Judged(coarse, coarse, own=False))
            else:
                self._simulate(self._own, world, lambda verdict: both(Judged(verdict, coarse)))

        def both(judged: Judged) -> None:
            pairs.append(judged)
            then(judged)

        self._simulate(self._coarse, world, settle)

    def _simulate(self, mesh: _Mesh, world: World, then: Callable[[Verdict], object]) -> None:
        """Begin a simulation, unless it was made before."""
        key = mesh.key(world)
        mesh.asked.add(key)
        known = self._memory.get(key)
        if known is None:
            future = self._workers.submit(judge, mesh.subject.task, mesh.subject.manipulation, world)
        else:
            future = Future()
            future.set_result(known)
        self._running[future] = (mesh, key, then)

    def _finish(self) -> None:
        """Wait until nothing is under way."""
        try:
            while self._running:
                ended, _ = wait(self._running, return_when=FIRST_COMPLETED)
                for future in ended:
                    self._end(future)
        finally:
            for future in self._running:
                future.cancel()  # of a run that was interrupted

    def _end(self, future: Future[Verdict]) -> None:
        """Take note of a simulation that has ended."""
        mesh, key, then = self._running.pop(future)
        verdict = _verdict_of(future)
        if self._memory.get(key) is None:
            self._memory.keep(key, verdict)
        mesh.ended.add(key)
        self._progress(sum(len(each.ended) for each in self._meshes), max(self._total, self.asked))
        then(verdict)


class _Mesh:
    """A fold on one mesh, and which worlds it was simulated in."""

    def __init__(self, subject: FoldOnMesh) -> None:
        self.subject = subject
        self._name = subject.key
        self.asked: set[str] = set()
        """Keys of simulations that were needed."""
        self.ended: set[str] = set()

    def key(self, world: World) -> str:
        return Memory.key(self._name, world)

    def has(self, world: World) -> bool:
        return self.key(world) in self.asked


def _verdict_of(future: Future[Verdict]) -> Verdict:
    """The verdict of a simulation that has ended; one that ended the processes it ran in has failed."""
    try:
        return future.result()
    except WorkerKilledError as error:
        return Verdict(None, None, str(error))


@dataclass(frozen=True)
class Settled:
    """Verdicts that do not hang on the mesh."""

    calm: Judged
    """Where nothing is off."""
    judged: list[Judged]
    """Of the worlds that were asked for."""
    ends: list[float | None]
    """Findings of the searches, in their order."""
    pairs: list[Judged]
    """All that is known on both meshes."""


def settled(
    asker: Asker, worlds: Sequence[World], limits: Limits, searches: Callable[[], list[Asking]] = list
) -> Settled:
    """Judge the undisturbed world and others, and follow searches, each on the mesh that its verdict needs.

    Args:
        asker: Simulates the fold.
        worlds: Some worlds.
        limits: What the fold must keep in order to hold.
        searches: Begins the searches; they begin once more whenever more is known about the meshes.
    """
    apart = Apart(limits)
    if asker.two_meshes:
        rough = [one.verdict for one in asker.run([CALM, *worlds], apart)[0][1:]]
        sample = [CALM, *(worlds[number] for number in sampled(rough, limits))]
        apart = apart.widened(asker.run(sample, Apart.everything(limits))[2])
    while True:
        (calm, *judged), ends, pairs = asker.run([CALM, *worlds], apart, searches())
        wider = apart.widened(pairs)
        if wider == apart:
            return Settled(calm, judged, ends, pairs)
        apart = wider
