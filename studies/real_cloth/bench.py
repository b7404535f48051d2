"""Simulates each experiment with real cloth once, and keeps the values that were read from it in a folder.

The values are called a reading. Its file name is a digest of the scene, of the kind of reading and of the simulator's
source code. If the simulator's code changes, the experiment is therefore simulated again. An interrupted run can be
resumed.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tatamu.base.errors import SimulationError, WorkerKilledError
from tatamu.base.files import read_json, write_json
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.side_by_side import executor_of
from tatamu.simulation.simulators import simulate
from tatamu.simulation.source import source_digest

Values = dict[str, Any]
"""Values that were read from a simulation. If the simulation failed, the key `failed` has the error message."""


@dataclass(frozen=True)
class Experiment:
    """A scene to simulate, and a function that reads values from the simulation."""

    label: str
    scene: Scene
    what: str
    """Name of the kind of values that are read from the simulation."""
    read: Callable[[Rollout], Values]


@dataclass(frozen=True)
class Bench:
    """A simulator of experiments, and the folder in which the values that were read from them are kept."""

    simulator: str
    folder: Path
    seeds: int = 3
    """Number of repeats of each simulated drape. Each repeat has another random unevenness of the cloth."""
    executor: Executor | None = None
    """Executor on which experiments are simulated and read; None to use a thread per processor in this process."""
    tick: Callable[[str], None] = lambda label: None
    """Function that is called with the label of each experiment when its values are known."""

    @property
    def version(self) -> str:
        """Digest of the source code that may change the result of a simulation."""
        return source_digest()

    def measure(self, experiments: Sequence[Experiment]) -> list[Values]:
        """Return the values of each experiment, simulated and kept unless they are kept already."""
        places = [self.folder / f"{self._key(each)}.json" for each in experiments]
        lacking = {place: each for place, each in zip(places, experiments, strict=True) if not place.exists()}
        given_up: dict[Path, Values] = {}
        for place, each in zip(places, experiments, strict=True):
            if place not in lacking:
                self.tick(each.label)
        with executor_of(self.executor, max(1, len(lacking))) as executor:
            begun = {
                executor.submit(reading, each.scene, each.read, self.simulator): place
                for place, each in lacking.items()
            }
            for ended in as_completed(begun):
                place = begun[ended]
                try:
                    write_json(place, ended.result())
                except WorkerKilledError as error:  # not kept, because another run may have better workers
                    given_up[place] = {"failed": str(error)}
                self.tick(lacking[place].label)
        return [given_up[place] if place in given_up else read_json(place) for place in places]

    def _key(self, experiment: Experiment) -> str:
        known = [self.simulator, experiment.what, self.version, experiment.scene.model_dump_json()]
        return hashlib.sha256(json.dumps(known).encode()).hexdigest()[:24]


def reading(scene: Scene, read: Callable[[Rollout], Values], simulator: str) -> Values:
    """Simulate a scene, and return the values that `read` finds in the simulation."""
    try:
        return read(simulate(scene, simulator))
    except SimulationError as error:
        return {"failed": str(error)}
