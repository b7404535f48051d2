"""Garments to fold on coarse meshes, and the simulations of them that are kept."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tatamu.evaluation import Nominal
from tatamu.evaluation.coarse import coarsened
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.parameters import Grasps, search_space
from tatamu.folding.score import residuals, vertex_distances
from tatamu.folding.task import Task, digest, make_task
from tatamu.garments import make_garment
from tatamu.search import Space


class Coarse(NamedTuple):
    """A garment to fold on cells so coarse that a fold takes a fraction of a second."""

    garment: str
    fold: str
    spacing: float
    """Of the mesh [m]."""
    softer: float = 1.0
    """How much softer to stretch than the garment's own cloth; by the square of the spacings' ratio, the cells lock as
    those of the default mesh do."""


GARMENTS = {
    "towel": Coarse("towel", "half", 0.03),
    "T-shirt": Coarse("tshirt", "half", 0.045),
    "trousers": Coarse("trousers", "leg", 0.045),
    "trousers, softer": Coarse("trousers", "leg", 0.045, (45.0 / 14.0) ** 2),
}


@dataclass(frozen=True)
class Simulated:
    """One simulation."""

    objective: float
    """C of Eq. (10)."""
    errors: np.ndarray | None
    """e_i of Eq. (12) [m], shape (n,); None where the trial failed."""

    @property
    def residuals(self) -> np.ndarray | None:
        """The vector whose squares sum to alpha D, shape (n,); None if the trial failed."""
        return None if self.errors is None else residuals(self.errors)

    @property
    def distance(self) -> float:
        """Mean vertex distance [m]; infinite where the trial failed."""
        return float("inf") if self.errors is None else float(self.errors.mean())


class Setting:
    """One garment to fold, and the simulations of it that are there."""

    def __init__(self, name: str, chosen: Coarse, folder: Path) -> None:
        """Open the simulations of a garment.

        Args:
            name: Name of the garment in tables and files.
            chosen: Garment, fold and mesh.
            folder: Folder of the simulations.
        """
        self.name = name
        garment = make_garment(chosen.garment, spacing=chosen.spacing)
        self.task: Task = make_task(coarsened(garment, 1.0, chosen.softer), fold=chosen.fold)
        folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / f"{chosen.garment}{'' if chosen.softer == 1.0 else '-softer'}.jsonl"
        self._known: dict[str, Simulated] = {}
        if self._file.exists():
            for line in self._file.read_text().splitlines():
                record = json.loads(line)
                errors = np.array(record["errors"]) if record["errors"] is not None else None
                self._known[record["key"]] = Simulated(record["objective"], errors)

    @property
    def fold(self) -> Fold:
        """The task of folding."""
        return self.task.fold

    @cached_property
    def spaces(self) -> dict[Grasps, Space]:
        """Bounds of the search, with whole and with floored grasps."""
        return {grasps: search_space(self.fold, grasps) for grasps in ("integer", "continuous")}

    def simulated(self, manipulation: Manipulation) -> Simulated:
        """The simulation of a manipulation; run only if it is not there."""
        assert manipulation.control_points is not None
        key = digest(np.array(manipulation.grasps), *manipulation.control_points)
        if key not in self._known:
            outcome = Nominal(self.task).fixed(manipulation)
            errors = None
            if not outcome.failed and outcome.rollout is not None:
                errors = vertex_distances(self.fold.target, outcome.rollout.positions[-1])
            record = {
                "key": key,
                "objective": outcome.objective,
                "errors": None if errors is None else errors.tolist(),
            }
            with self._file.open("a") as file:
                file.write(json.dumps(record) + "\n")
            self._known[key] = Simulated(outcome.objective, errors)
        return self._known[key]
