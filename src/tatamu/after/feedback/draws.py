"""The simulated scenarios with which measured folds are compared. `tatamu margins` shares them, by a common file."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

from tatamu.after.margins.measurement import KEPT
from tatamu.evaluation.disturbances import Disturbances, Stream, World, mean_world, sample_worlds
from tatamu.evaluation.draws import Draws, Progress, Subject
from tatamu.evaluation.outcome import Outcome
from tatamu.simulation.side_by_side import executor_of, processors
from tatamu.simulation.simulators import capabilities
from tatamu.study.result import Result

SCENARIOS = 100
"""Number of scenarios: the first draws of `tatamu margins`."""


@dataclass(frozen=True)
class Simulated:
    """A fold in scenarios."""

    subject: Subject
    scenarios: list[tuple[World, Outcome]]
    """Scenarios and their outcomes; the first has every disturbance at its mean."""

    @property
    def nominal(self) -> Outcome:
        """The outcome if every disturbance has its mean."""
        return self.scenarios[0][1]


def simulate_scenarios(
    learned: Result,
    disturbances: Disturbances,
    out: Path | None,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Simulated:
    """Simulate a fold in scenarios. Those in the folder `out` are not repeated, and new ones are kept there."""
    subject = Subject(replace(learned.task, reach=None), learned.best.parameters)
    scenarios = [mean_world(disturbances), *sample_worlds(disturbances, SCENARIOS, 0, Stream.MARGINS)]
    threads = processors() if capabilities(subject.task.simulator).parallel else 1
    with executor_of(executor, threads) as workers:
        draws = Draws(subject, workers, None if out is None else out / KEPT, progress)
        return Simulated(subject, list(zip(scenarios, draws.outcomes(scenarios), strict=True)))
