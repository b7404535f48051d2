"""Simulates folds of garments on coarse meshes, and keeps the results of the simulations."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tatamu import Evaluation, Manipulation, Nominal, Space, Task, make_garment, make_task
from tatamu.evaluation.coarse import coarsened
from tatamu.folding.fold import Fold
from tatamu.folding.parameters import Grasps, search_space
from tatamu.folding.score import residuals, vertex_distances


class Coarse(NamedTuple):
    """A garment on a coarse mesh, so a simulation of its fold takes only a fraction of a second."""

    garment: str
    fold: str
    spacing: float
    """Edge length ("spacing") of the coarse mesh [m]."""
    softer: float = 1.0
    """Factor by which the cloth is easier to stretch than the garment's usual cloth.

    With the usual cloth, a coarse mesh is too stiff against bending in two directions. The suitable factor is the
    square of a ratio: the spacing divided by the default spacing.
    """


GARMENTS = {
    "towel": Coarse("towel", "half", 0.03),
    "T-shirt": Coarse("tshirt", "half", 0.045),
    "trousers": Coarse("trousers", "leg", 0.045),
    "trousers, softer": Coarse("trousers", "leg", 0.045, (45.0 / 14.0) ** 2),
}


@dataclass(frozen=True)
class Simulated:
    """The result of the simulation of a fold."""

    objective: float
    """Objective C of the simulated fold, Eq. (10)."""
    errors: np.ndarray | None
    """Vertex errors e_i of the simulated fold, Eq. (12) [m], shape (n,); None if the trial failed."""

    @property
    def distance(self) -> float:
        """Mean distance of the vertices from their targets [m]; infinite if the trial failed."""
        return float("inf") if self.errors is None else float(self.errors.mean())

    @property
    def residuals(self) -> np.ndarray | None:
        """Vector for a least-squares search, whose sum of squares is alpha D, shape (n,); None if the trial failed.

        D is the shape distance of Eq. (11), and alpha is its weight in the objective. The vertex errors have single
        precision.
        """
        return None if self.errors is None else residuals(self.errors.astype(np.float32).astype(float))


class Setting:
    """A garment to fold, and the results of the simulations that are kept for it."""

    def __init__(self, name: str, chosen: Coarse, folder: Path) -> None:
        """Load the kept results of the simulations of a garment.

        Args:
            name: Name of the garment in tables and files.
            chosen: Garment, fold and mesh.
            folder: Folder in which the results are kept.
        """
        self.name = name
        garment = coarsened(make_garment(chosen.garment, spacing=chosen.spacing), 1.0, chosen.softer)
        self.task: Task = make_task(garment, fold=chosen.fold)
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
        """The fold of the garment, with its grasps and target."""
        return self.task.fold

    @cached_property
    def spaces(self) -> dict[Grasps, Space]:
        """Search spaces of the fold, by the type of the parameters that choose the grasps.

        These parameters are whole numbers, or continuous numbers that are rounded down.
        """
        return {"integer": search_space(self.fold, "integer"), "continuous": search_space(self.fold, "continuous")}

    def simulated(self, manipulation: Manipulation) -> Simulated:
        """Return the result of a manipulation, a motion of the hands.

        The manipulation is only simulated if its result is not kept yet.
        """
        assert manipulation.control_points is not None
        key = _digest(np.array(manipulation.grasps), *manipulation.control_points)
        if key not in self._known:
            outcome = Nominal(self.task).fixed(manipulation)
            errors = self._errors(outcome)
            record = {
                "key": key,
                "objective": outcome.objective,
                "errors": None if errors is None else errors.tolist(),
            }
            with self._file.open("a") as file:
                file.write(json.dumps(record) + "\n")
            self._known[key] = Simulated(outcome.objective, errors)
        return self._known[key]

    def _errors(self, outcome: Evaluation) -> np.ndarray | None:
        """Return the vertex errors e_i of a simulation [m], shape (n,); None if the simulation failed."""
        if outcome.failed or outcome.rollout is None:
            return None
        return vertex_distances(self.fold.target, outcome.rollout.positions[-1])


def _digest(*arrays: np.ndarray) -> str:
    """Return a digest of arrays, which changes if any bit of the arrays changes."""
    data = b"".join(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in arrays)
    return hashlib.sha256(data).hexdigest()[:16]
