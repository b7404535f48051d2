"""Runs studies with the searches that are compared, and keeps the studies in files."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from studies.search.methods import METHODS
from studies.search.settings import Setting, Simulated

from tatamu.base.files import write_text


@dataclass(frozen=True)
class Course:
    """The course of a study: the objectives and the mean vertex distances [m] of its trials, in order."""

    objectives: list[float]
    distances: list[float]

    def best(self, count: int) -> tuple[float, float]:
        """Return the lowest objective among the first `count` trials.

        The second result is the mean vertex distance [m] of the trial with this objective.
        """
        place = int(np.argmin(self.objectives[:count]))
        return self.objectives[place], self.distances[place]


class Studies:
    """The finished studies of all searches, which are kept in a folder."""

    def __init__(self, out: Path) -> None:
        """Open the folder of the studies, and create it if it does not exist."""
        self._folder = out / "studies"
        self._folder.mkdir(parents=True, exist_ok=True)

    def run(self, method: str, setting: Setting, seed: int, trials: int) -> None:
        """Run a study with `trials` trials, unless it exists already."""
        held = self.course(setting.name, method, seed)
        if held is not None and len(held.objectives) >= trials:
            return
        before: list[tuple[Any, Simulated]] = []
        for number in range(trials):
            parameters, manipulation = METHODS[method].propose(setting, seed, number, before)
            before.append((parameters, setting.simulated(manipulation)))
        records = [
            {"parameters": parameters, "objective": simulated.objective, "distance": simulated.distance}
            for parameters, simulated in before
        ]
        write_text(self._path(setting.name, method, seed), json.dumps(records))

    def course(self, garment: str, method: str, seed: int) -> Course | None:
        """Return the course of a finished study; None if the study does not exist."""
        path = self._path(garment, method, seed)
        if not path.exists():
            return None
        records = json.loads(path.read_text())
        return Course([each["objective"] for each in records], [each["distance"] for each in records])

    def courses(self, garment: str, method: str, count: int, seeds: int = 100) -> list[Course]:
        """Return the courses of the studies of a search method that have at least `count` trials.

        Only the first `seeds` random seeds are used.
        """
        found = [self.course(garment, method, seed) for seed in range(seeds)]
        return [each for each in found if each is not None and len(each.objectives) >= count]

    def _path(self, garment: str, method: str, seed: int) -> Path:
        return self._folder / f"{garment}-{method}-{seed}.json"
