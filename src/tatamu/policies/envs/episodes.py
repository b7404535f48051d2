"""Episodes of one task, each in a scenario of its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import CHANNELS, NOMINAL, Disturbances, Scenario, disturbed_scene, load_disturbances
from tatamu.evaluation.disturbances.scenario import scenarios_of
from tatamu.folding.fold import Fold
from tatamu.folding.parameters import arched_curve
from tatamu.folding.task import Task, make_task
from tatamu.garments import Garment
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Scene


@dataclass(frozen=True)
class Episodes:
    """A task, and the disturbances of its episodes."""

    task: Task
    disturbances: Disturbances | None

    def draw(self, generator: np.random.Generator) -> Scenario:
        """Draw the scenario of an episode."""
        return draw_scenario(self.disturbances, generator)

    def untouched(self, scenario: Scenario) -> Scene:
        """Return the scene of a scenario without hands."""
        fold = self.task.fold
        touched = disturbed_scene(fold, self.task.manipulation(arched_curve(fold)), scenario)
        return touched.model_copy(update={"grippers": []})


def draw_scenario(disturbances: Disturbances | None, generator: np.random.Generator) -> Scenario:
    """Draw a scenario; without disturbances, it is the nominal one."""
    if disturbances is None:
        return NOMINAL
    return scenarios_of(disturbances, [generator.standard_normal(len(CHANNELS))])[0]


def make_episodes(
    garment: Task | Garment | str | Path,
    fold: str,
    size: tuple[float, float] | None,
    material: Material | Path | str | None,
    spacing: float | None,
    disturbances: Disturbances | Path | str | None,
) -> Episodes:
    """Make the episodes of an environment, whose arguments these are."""
    if not (disturbances is None or isinstance(disturbances, Disturbances)):
        disturbances = load_disturbances(str(disturbances))
    if isinstance(garment, Task):
        if (fold, size, material, spacing) != ("half", None, None, None):
            raise InputError(
                "fold, size, material, spacing: must be left out with a task, which has its own; give these values to "
                "make_task"
            )
        return Episodes(garment, disturbances)
    task = make_task(garment, fold=fold, size=size, material=material, spacing=spacing)
    return Episodes(task, disturbances)


def hand_errors(fold: Fold, scenario: Scenario, hands: int) -> np.ndarray:
    """Return the error of each hand's assumed position in a scenario [m], shape (hands, 3)."""
    place = np.array([scenario["cloth.place.along"], scenario["cloth.place.across"], scenario["table.height"]])
    shared = scenario.vector("hands.offset") - place
    apart = 0.5 * scenario.vector("hands.difference")
    errors = [shared] if hands == 1 else [shared + apart, shared - apart]
    axes = np.array([[*fold.normal, 0.0], [*fold.crease.along, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(np.array(errors) @ axes)
