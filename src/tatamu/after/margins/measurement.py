"""Margins of a learned fold: how often it succeeds with all disturbances at once, and the range of each alone.

The range of one disturbance is found by bisection.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

from tatamu.base.errors import InputError, check_range
from tatamu.base.version import __version__
from tatamu.evaluation.disturbances import (
    CHANNELS,
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
    check_range("draws", draws, 1, 100_000)
    check_range("seed", seed, 0, 2**32 - 1)
    if not (known := deviations(disturbances)):
        raise InputError("disturbances: must have at least one standard deviation above 0, given only zeros")
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
        ranges = _ranges(known, centre, nominal, simulated, limits) if alone else []
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
            alone=ranges,
            together=success,
            moving_vertex_distance=Spread.of(distances_of(task.fold, found, moving=True)),
            simulations=simulated.simulations,
            spacing=task.garment.spacing,
            disturbances=disturbances.describe(),
        ),
        sorted(ranked, key=lambda draw: (-draw.distance, draw.number)),
    )


@dataclass(frozen=True)
class _Side:
    """One direction of one disturbance, from its mean."""

    channel: Channel
    mean: float
    step: float
    """One standard deviation in this direction."""

    def value(self, deviations: float) -> float:
        return self.mean + deviations * self.step

    def shown(self, deviations: float) -> float:
        """Return a disturbance as files have it."""
        return self.channel.shown(self.value(deviations))


def _ranges(
    known: Mapping[str, float], centre: Scenario, nominal: Outcome, draws: Draws, limits: Limits
) -> list[AloneMargin]:
    """Return the range of each disturbance with a known deviation, while the others stay as in `centre`."""
    channels = [channel for channel in CHANNELS if channel.name in known]
    sides = [_Side(each, centre[each.name], sign * known[each.name]) for each in channels for sign in (-1.0, 1.0)]
    ends = _bisect(sides, centre, draws, limits) if limits.hold(nominal) else [0.0] * len(sides)
    return [
        AloneMargin(
            name=above.channel.name,
            unit=above.channel.unit,
            low=low,
            high=high,
            deviation=above.step,
            mean=above.mean,
            tried=(below.shown(MAX_DEVIATIONS), above.shown(MAX_DEVIATIONS)),
        )
        for below, above, low, high in zip(sides[::2], sides[1::2], ends[::2], ends[1::2], strict=True)
    ]


def _bisect(sides: Sequence[_Side], centre: Scenario, draws: Draws, limits: Limits) -> list[float | None]:
    """Find the largest disturbance of each side at which the fold still succeeds; None if it does at the largest tried.

    All sides are bisected at the same time, so that their simulations run side by side.
    """

    def succeed(tried: Mapping[int, float]) -> list[bool]:
        moved = [(sides[index].channel.name, sides[index].value(deviations)) for index, deviations in tried.items()]
        scenarios = [Scenario({**centre.values, name: value}) for name, value in moved]
        return [limits.hold(outcome) for outcome in draws.outcomes(scenarios)]

    low, high = [0.0] * len(sides), [MAX_DEVIATIONS] * len(sides)
    beyond = succeed(dict(enumerate(high)))
    for _ in range(3):  # the last range is an eighth of `MAX_DEVIATIONS`, 0.4 deviations
        middles = {i: 0.5 * (low[i] + high[i]) for i in range(len(sides)) if not beyond[i]}
        for (index, middle), succeeds in zip(middles.items(), succeed(middles), strict=True):
            (low if succeeds else high)[index] = middle
    return [None if reached else side.shown(end) for side, end, reached in zip(sides, low, beyond, strict=True)]
