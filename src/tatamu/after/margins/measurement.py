"""Margins of a learned fold: how often it succeeds with all disturbances at once, and the range of each alone.

The range of one disturbance is found by bisection.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.base.version import __version__
from tatamu.evaluation.disturbances import (
    CHANNELS,
    NOMINAL,
    Channel,
    Disturbances,
    Scenario,
    Stream,
    deviations,
    mean_scenario,
    sample_scenarios,
)
from tatamu.evaluation.draws import Draws, Progress, Subject
from tatamu.evaluation.outcome import Outcome
from tatamu.evaluation.success import AloneMargin, MarginsRecord, Spread, Success, distances_of
from tatamu.folding.score import Limits
from tatamu.simulation.side_by_side import executor_of, processors
from tatamu.simulation.simulators import capabilities
from tatamu.study.result import Result

MAX_DEVIATIONS = 3.0
"""Largest disturbance that is tried, in deviations. Larger ones occur once in 400 folds."""


@dataclass(frozen=True)
class Side:
    """One direction of one disturbance, from its mean."""

    channel: Channel
    deviation: float
    sign: float
    centre: Scenario = NOMINAL

    def scenario(self, deviations: float) -> Scenario:
        """Return the scenario in which only this disturbance differs from its mean."""
        return Scenario({**self.centre.values, self.channel.name: self._value(deviations)})

    def shown(self, deviations: float) -> float:
        """Return a disturbance, given in deviations, in the unit that files use."""
        return self.channel.shown(self._value(deviations))

    def _value(self, deviations: float) -> float:
        return self.centre[self.channel.name] + self.sign * deviations * self.deviation


DRAWS = 200
KEPT = "simulated.jsonl"
"""Name of the file in which outcomes are kept."""


@dataclass(frozen=True)
class Draw:
    """One scenario in which all disturbances are random."""

    number: int
    scenario: Scenario
    outcome: Outcome
    distance: float
    """Mean distance from the target [m]; twice that of untouched cloth if the simulation failed."""


@dataclass(frozen=True)
class Measured:
    """The margins of a learned fold."""

    learned: Result
    subject: Subject
    result: MarginsRecord
    draws: list[Draw]
    """Random scenarios, the worst first."""

    @property
    def success(self) -> Success:
        """How often the fold succeeds."""
        return self.result.together

    @property
    def share(self) -> float:
        """Former name of `success.rate`."""
        return self.success.rate


def measure(
    learned: Result,
    disturbances: Disturbances,
    *,
    out: Path | None = None,
    draws: int = DRAWS,
    seed: int = 0,
    limits: Limits | None = None,
    simulator: str | None = None,
    alone: bool = True,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
    together: Callable[[Success], object] = lambda success: None,
) -> Measured:
    """Measure the margins of a fold.

    Args:
        learned: The fold.
        disturbances: Standard deviations, and means, of the disturbances.
        out: Folder in which outcomes are kept; None to keep them in memory.
        draws: How many scenarios have all disturbances at random.
        seed: Seed of these scenarios.
        limits: Limits of a successful fold; None for the usual ones.
        simulator: Name of the simulator; None for that of the fold.
        alone: Whether to find the range of each disturbance, too.
        executor: Executor of the simulations; None for threads on all processors.
        progress: Called after every simulation.
        together: Called with the success rate, before the ranges are found.

    Raises:
        InputError: If an argument is out of range.
    """
    limits = limits or Limits()
    if not 1 <= draws <= 100_000:
        raise InputError(f"draws: must be from 1 to 100000, given {draws}")
    if not 0 <= seed < 2**32:
        raise InputError(f"seed: must be from 0 to {2**32 - 1}, given {seed}")
    if not (known := deviations(disturbances)):
        raise InputError("disturbances: must contain at least one deviation above 0, given none")
    task = replace(learned.task, reach=None, simulator=simulator or learned.simulator)
    subject = Subject(task, learned.best.parameters)
    threads = processors() if capabilities(task.simulator).parallel else 1
    centre = mean_scenario(disturbances)
    scenarios = sample_scenarios(disturbances, draws, seed, Stream.MARGINS)
    with executor_of(executor, threads) as workers:
        simulated = Draws(subject, workers, None if out is None else out / KEPT, progress)
        nominal, *found = simulated.outcomes([centre, *scenarios])
        success = Success.of(task.fold, found, limits)
        together(success)
        channels = [channel for channel in CHANNELS if channel.name in known] if alone else []
        sides = [Side(channel, known[channel.name], sign, centre) for channel in channels for sign in (-1.0, 1.0)]
        ends = _bisect(sides, simulated, limits) if limits.hold(nominal) else [0.0] * len(sides)
    distances = distances_of(task.fold, found)
    ranked = [
        Draw(number, scenario, outcome, distance)
        for number, (scenario, outcome, distance) in enumerate(zip(scenarios, found, distances, strict=True))
    ]
    return Measured(
        learned,
        subject,
        MarginsRecord(
            tatamu=__version__,
            simulator=task.simulator,
            seed=seed,
            limits=limits,
            undisturbed=nominal.mean_vertex_distance,
            alone=_alone(sides, ends),
            together=success,
            moving_vertex_distance=Spread.of(distances_of(task.fold, found, moving=True)),
            simulations=simulated.simulations,
            spacing=task.garment.spacing,
            disturbances=disturbances.describe(),
        ),
        sorted(ranked, key=lambda draw: (-draw.distance, draw.number)),
    )


def _bisect(sides: Sequence[Side], draws: Draws, limits: Limits) -> list[float | None]:
    """Find the largest disturbance of each side at which the fold still succeeds; None if it does at the largest tried.

    All sides are bisected at the same time, so that their simulations run side by side.
    """

    def succeed(tried: Mapping[int, float]) -> list[bool]:
        scenarios = [sides[index].scenario(deviations) for index, deviations in tried.items()]
        return [limits.hold(outcome) for outcome in draws.outcomes(scenarios)]

    low, high = [0.0] * len(sides), [MAX_DEVIATIONS] * len(sides)
    beyond = succeed(dict(enumerate(high)))
    for _ in range(3):  # the last range is an eighth of `MAX_DEVIATIONS`, 0.4 deviations
        middles = {i: 0.5 * (low[i] + high[i]) for i in range(len(sides)) if not beyond[i]}
        for (index, middle), succeeds in zip(middles.items(), succeed(middles), strict=True):
            (low if succeeds else high)[index] = middle
    return [None if reached else side.shown(end) for side, end, reached in zip(sides, low, beyond, strict=True)]


def _alone(sides: Sequence[Side], ends: Sequence[float | None]) -> list[AloneMargin]:
    pairs = zip(sides[::2], sides[1::2], ends[::2], ends[1::2], strict=True)
    return [
        AloneMargin(
            name=below.channel.name,
            unit=below.channel.unit,
            low=low,
            high=high,
            deviation=below.deviation,
            mean=below.centre[below.channel.name],
            tried=(below.shown(MAX_DEVIATIONS), above.shown(MAX_DEVIATIONS)),
        )
        for below, above, low, high in pairs
    ]
