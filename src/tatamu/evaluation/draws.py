"""Simulates a fold in many scenarios, side by side. What was simulated is kept, so an interrupted run goes on."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from tatamu.base.errors import WorkerKilledError
from tatamu.base.files import read_text, writing
from tatamu.evaluation.disturbances import NOMINAL, Scenario, disturbed_scene
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.outcome import Outcome
from tatamu.folding.task import Task
from tatamu.simulation.source import source_digest

VERSION = 4
"""Version of the kept outcomes. Outcomes of other versions are simulated again."""
Progress = Callable[[int, int], object]
"""Is called with how many simulations have ended, and how many are known to be needed."""
_LINE = TypeAdapter(Outcome)


@dataclass(frozen=True)
class Subject:
    """A manipulation of a task, which is simulated in scenarios."""

    task: Task
    parameters: Mapping[str, int | float]

    @cached_property
    def digest(self) -> str:
        """Digest of the undisturbed scene and of the simulator's code."""
        scene = disturbed_scene(self.task.fold, self.task.manipulation(self.parameters), NOMINAL)
        known = f"{VERSION} {self.task.simulator} {source_digest()} {scene.model_dump_json()}"
        return sha256(known.encode()).hexdigest()[:16]

    def key(self, scenario: Scenario) -> str:
        values = sorted((name, value.hex()) for name, value in scenario.values.items() if value)
        return sha256(json.dumps([self.digest, values]).encode()).hexdigest()[:24]


@dataclass(eq=False)
class Draws:
    """Outcomes of a subject, each simulated once."""

    subject: Subject
    workers: Executor
    file: Path | None = None
    """File in which outcomes are kept, one a line. An incomplete line is skipped."""
    progress: Progress = lambda done, total: None

    def __post_init__(self) -> None:
        """Read the outcomes that are kept."""
        self._known = {} if self.file is None else read_outcomes(self.file)
        self._asked: set[str] = set()
        if self.file is not None:
            with writing(self.file.parent):
                self.file.parent.mkdir(parents=True, exist_ok=True)

    @property
    def simulations(self) -> int:
        """How many outcomes were asked for, those that were kept included."""
        return len(self._asked)

    def outcomes(self, scenarios: Sequence[Scenario]) -> list[Outcome]:
        """Return the outcomes in scenarios, in their order."""
        keys = [self.subject.key(each) for each in scenarios]
        self._asked.update(keys)
        missing = {key: each for key, each in zip(keys, scenarios, strict=True) if key not in self._known}
        futures = {
            self.workers.submit(simulate_outcome, self.subject.task, self.subject.parameters, each): key
            for key, each in missing.items()
        }
        try:
            for left, future in zip(range(len(futures) - 1, -1, -1), as_completed(futures), strict=True):
                self._keep(futures[future], _result(future))
                self.progress(self.simulations - left, self.simulations)
        finally:
            for future in futures:
                future.cancel()  # only has an effect after an interruption
        return [self._known[key] for key in keys]

    def _keep(self, key: str, outcome: Outcome) -> None:
        self._known[key] = outcome
        if self.file is None:
            return
        with writing(self.file), self.file.open("ab+") as file:
            file.seek(max(file.seek(0, 2) - 1, 0))
            start = b"" if file.read(1) in (b"", b"\n") else b"\n"  # the last line may be incomplete
            file.write(start + json.dumps({"key": key, **_LINE.dump_python(outcome)}).encode() + b"\n")


def read_outcomes(file: Path) -> dict[str, Outcome]:
    """Return the outcomes that a file keeps, by their keys. What is no outcome is passed over."""
    found = {}
    for line in read_text(file).splitlines() if file.exists() else ():
        try:
            value = json.loads(line)
            key = value.pop("key")
            found[key] = _LINE.validate_json(json.dumps(value), strict=True)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError, ValidationError):
            continue
    return found


def simulate_outcome(task: Task, parameters: Mapping[str, int | float], scenario: Scenario) -> Outcome:
    """Simulate a manipulation in a scenario."""
    return Outcome.of(Nominal(task).simulate(parameters, scenario), task.fold)


def _result(future: Future[Outcome]) -> Outcome:
    """Return an outcome. A simulation that killed its processes is a failed one."""
    try:
        return future.result()
    except WorkerKilledError as error:
        return Outcome(None, None, str(error))
