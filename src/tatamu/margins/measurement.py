"""Margins of a learned fold: each disturbance alone, and all of them at once in many draws."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu import __version__
from tatamu.disturbances import (
    CALM,
    CHANNELS,
    Disturbances,
    Limits,
    Stream,
    Verdict,
    World,
    deviations,
    drawn,
    judge,
)
from tatamu.errors import InputError, WorkerKilledError
from tatamu.margins.alone import LEAPS, Asking, Side
from tatamu.margins.memory import Memory
from tatamu.margins.subject import FoldOnMesh, coarse, subject_of
from tatamu.results import RebuiltFold
from tatamu.results.joint import joint_margin
from tatamu.results.margins import AloneMargin, HoldLimits, MarginsResult, MeshUsed
from tatamu.simulators import capabilities
from tatamu.simulators.many import executor_of, processors

DRAWS = 200
"""How many joint draws there are unless somebody asks for another number."""
CHECKED = 6
"""Draws nearest to the limit that are simulated on the fold's own mesh too."""
KEPT = "simulated.jsonl"
"""The file that keeps simulations, beside `margins.json`."""

Progress = Callable[[int, int], None]
"""Called with how many simulations have ended and how many are known to be needed."""


@dataclass(frozen=True)
class Draw:
    """One joint draw."""

    number: int
    world: World
    verdict: Verdict


@dataclass(frozen=True)
class Measured:
    """Margins, and what a page shows beside them."""

    learned: RebuiltFold
    subject: FoldOnMesh
    """As simulated."""
    result: MarginsResult
    draws: list[Draw]
    """From the worst to the best."""


def measure(
    folder: Path,
    disturbances: Disturbances,
    *,
    out: Path,
    draws: int = DRAWS,
    seed: int = 0,
    limits: Limits | None = None,
    simulator: str | None = None,
    fine: bool = False,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Measured:
    """Measure the margins of a learned fold, or go on where it was interrupted.

    Args:
        folder: The learned fold's.
        disturbances: What is not known, and how far it may be off.
        out: Where simulations are kept.
        draws: How many joint draws.
        seed: Of the draws.
        limits: What the fold must keep in order to hold; None: the field's.
        simulator: In which simulator; None: where it was learned.
        fine: On the fold's own mesh, even where a coarser one does.
        executor: Where simulations run; None: threads on every processor, where the simulator can.
        progress: Called after every simulation.

    Raises:
        InputError: An argument is out of range, or the folder holds no learned fold.
    """
    limits = limits or Limits()
    check_draws(draws, seed)
    if not deviations(disturbances):
        raise InputError("disturbances: must have a deviation above 0, given none")
    learned, own = subject_of(folder, simulator)
    coarser = None if fine or simulator not in (None, learned.simulator) else coarse(learned, own, limits)
    subject = coarser or own
    memory = Memory(out / KEPT)
    threads = processors() if capabilities(subject.task.simulator).parallel else 1
    with executor_of(executor, threads) as workers:
        asker = _Asker(workers, memory, progress)
        worlds = drawn(disturbances, draws, seed, Stream.MARGINS)
        sides = _sides(disturbances)
        searches = [side.search(limits) for side in sides]
        calm, ends, verdicts = asker.run(subject, searches, worlds)
        ranked = _ranked(worlds, verdicts)
        checked = [] if coarser is None else _nearest(ranked, limits)
        again = asker.run(own, [], [draw.world for draw in checked])[2]
    held = calm.holds(limits)
    return Measured(
        learned,
        subject,
        MarginsResult(
            tatamu=__version__,
            simulator=subject.task.simulator,
            seed=seed,
            limits=HoldLimits(mean_vertex_distance=limits.mean_vertex_distance, mask_iou=limits.mask_iou),
            undisturbed=calm.mean_vertex_distance,
            alone=_alone(sides, ends if held else [0.0] * len(sides)),
            joint=joint_margin(subject.task, verdicts, limits),
            mesh=_mesh(subject, checked, again, limits, coarser is not None),
            simulations=asker.asked,
            disturbances=disturbances.describe(),
        ),
        ranked,
    )


def check_draws(draws: int, seed: int) -> None:
    """Refuse draws that cannot be."""
    if not 1 <= draws <= 100_000:
        raise InputError(f"draws: must be from 1 to 100000, given {draws}")
    if not 0 <= seed < 2**32:
        raise InputError(f"seed: must be from 0 to {2**32 - 1}, given {seed}")


@dataclass
class _Lane:
    """Worlds that are asked for one after another."""

    search: Asking
    end: float | None = None


class _Asker:
    """Simulates worlds anywhere, and keeps what it learns."""

    def __init__(self, workers: Executor, memory: Memory, progress: Progress) -> None:
        self._workers = workers
        self._memory = memory
        self._progress = progress
        self.asked = 0
        """How many simulations were needed, those that were kept from before among them."""
        self._total = 0

    def run(
        self, subject: FoldOnMesh, searches: Sequence[Asking], worlds: Sequence[World]
    ) -> tuple[Verdict, list[float | None], list[Verdict]]:
        """Ask for the undisturbed world, follow searches to their ends, and ask for some worlds.

        Returns:
            The verdict of the undisturbed world, what the searches found, and the verdicts of the worlds.
        """
        queue = _Queue(self, subject)
        calm: list[Verdict] = []
        found: dict[int, Verdict] = {}
        lanes = [_Lane(search) for search in searches]
        self._total += 1 + len(lanes) * len(LEAPS) + len(worlds)
        queue.ask(CALM, calm.append)
        for lane in lanes:
            queue.follow(lane)
        for number, world in enumerate(worlds):
            queue.ask(world, lambda verdict, number=number: found.update({number: verdict}))  # type: ignore[misc]
        queue.finish()
        return calm[0], [lane.end for lane in lanes], [found[number] for number in range(len(worlds))]

    def begin(self, subject: FoldOnMesh, key: str, world: World) -> Future[Verdict]:
        """Begin a simulation, unless it was made before."""
        known = self._memory.get(key)
        if known is None:
            return self._workers.submit(judge, subject.task, subject.manipulation, world)
        ended: Future[Verdict] = Future()
        ended.set_result(known)
        return ended

    def end(self, key: str, verdict: Verdict) -> None:
        """Take note of a simulation that has ended."""
        if self._memory.get(key) is None:
            self._memory.keep(key, verdict)
        self.asked += 1
        self._progress(self.asked, max(self._total, self.asked))


class _Queue:
    """Simulations of one subject that are under way, and what is done with their verdicts."""

    def __init__(self, asker: _Asker, subject: FoldOnMesh) -> None:
        self._asker = asker
        self._subject = subject
        self._name = subject.key
        self._running: dict[Future[Verdict], tuple[str, Callable[[Verdict], None]]] = {}

    def ask(self, world: World, then: Callable[[Verdict], object]) -> None:
        """Simulate a world, then hand on its verdict."""
        key = Memory.key(self._name, world)
        self._running[self._asker.begin(self._subject, key, world)] = (key, then)  # type: ignore[assignment]

    def follow(self, lane: _Lane, verdict: Verdict | None = None) -> None:
        """Ask for the next world of a search."""
        try:
            world = next(lane.search) if verdict is None else lane.search.send(verdict)
        except StopIteration as stop:
            lane.end = stop.value
            return
        self.ask(world, lambda verdict: self.follow(lane, verdict))

    def finish(self) -> None:
        """Wait until nothing is under way."""
        try:
            while self._running:
                ended, _ = wait(self._running, return_when=FIRST_COMPLETED)
                for future in ended:
                    key, then = self._running.pop(future)
                    verdict = _verdict_of(future)
                    self._asker.end(key, verdict)
                    then(verdict)
        finally:
            for future in self._running:
                future.cancel()  # of a run that was interrupted


def _verdict_of(future: Future[Verdict]) -> Verdict:
    """The verdict of a simulation that has ended; one that ended the processes it ran in has failed."""
    try:
        return future.result()
    except WorkerKilledError as error:
        return Verdict(None, None, str(error))


def _sides(disturbances: Disturbances) -> list[Side]:
    """Every disturbance in both directions, below zero before above."""
    known = deviations(disturbances)
    channels = [channel for channel in CHANNELS if channel.name in known]
    return [Side(channel, known[channel.name], sign) for channel in channels for sign in (-1.0, 1.0)]


def _alone(sides: Sequence[Side], ends: Sequence[float | None]) -> list[AloneMargin]:
    pairs = zip(sides[::2], sides[1::2], ends[::2], ends[1::2], strict=True)
    return [
        AloneMargin(
            name=below.channel.name,
            unit=below.channel.unit,
            low=low,
            high=high,
            deviation=below.deviation,
            tried=(below.shown(LEAPS[-1]), above.shown(LEAPS[-1])),
        )
        for below, above, low, high in pairs
    ]


def _ranked(worlds: Sequence[World], verdicts: Sequence[Verdict]) -> list[Draw]:
    """Draws from the worst to the best."""
    draws = [Draw(number, world, verdict) for number, (world, verdict) in enumerate(zip(worlds, verdicts, strict=True))]
    return sorted(draws, key=lambda draw: (-_badness(draw.verdict), draw.number))


def _badness(verdict: Verdict) -> float:
    return np.inf if verdict.mean_vertex_distance is None else verdict.mean_vertex_distance


def _nearest(draws: Sequence[Draw], limits: Limits) -> list[Draw]:
    """The draws whose verdict hangs most on the mesh: those that end nearest to the limit."""
    near = sorted(draws, key=lambda draw: abs(_badness(draw.verdict) - limits.mean_vertex_distance))
    return near[:CHECKED]


def _mesh(
    subject: FoldOnMesh, checked: Sequence[Draw], again: Sequence[Verdict], limits: Limits, coarser: bool
) -> MeshUsed:
    pairs = list(zip((draw.verdict for draw in checked), again, strict=True))
    apart = [
        abs(one.mean_vertex_distance - other.mean_vertex_distance)
        for one, other in pairs
        if one.mean_vertex_distance is not None and other.mean_vertex_distance is not None
    ]
    return MeshUsed(
        spacing=subject.task.fold.garment.spacing,
        vertices=len(subject.task.fold.start),
        coarser=coarser,
        checked=len(pairs),
        same=sum(one.holds(limits) == other.holds(limits) for one, other in pairs),
        apart=max(apart, default=0.0),
    )
