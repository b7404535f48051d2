"""What both environments share: one task, whose episodes each have a scenario of their own, and its observations."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from copy import deepcopy
from pathlib import Path

import gymnasium
import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import CHANNELS, NOMINAL, Disturbances, Scenario, load_disturbances
from tatamu.evaluation.disturbances.scenario import scenarios_of
from tatamu.folding.task import Task, make_task
from tatamu.garments import Garment
from tatamu.policies.envs.observation import Observation, Observer, View
from tatamu.simulation.material import Material


class GarmentEnv(gymnasium.Env[Observation, np.ndarray]):
    """An environment in which one garment is folded, and whose pictures show the last `_view`."""

    def __init__(
        self,
        garment: Task | Garment | str | Path,
        fold: str,
        size: tuple[float, float] | None,
        material: Material | Path | str | None,
        spacing: float | None,
        disturbances: Disturbances | Path | str | None,
        observation: str | tuple[str, ...],
        pixels: int,
        render_mode: str | None,
        *,
        with_hands: bool,
    ) -> None:
        """Make the environment. `HandsEnv` explains the arguments, but `with_hands`: whether hands can be observed."""
        if not (disturbances is None or isinstance(disturbances, Disturbances)):
            disturbances = load_disturbances(str(disturbances))
        if not isinstance(garment, Task):
            garment = make_task(garment, fold=fold, size=size, material=material, spacing=spacing)
        elif (fold, size, material, spacing) != ("half", None, None, None):
            raise InputError(
                "fold, size, material, spacing: must be left out if garment is a Task; give these values to make_task"
            )
        self.task = garment
        self.disturbances = disturbances
        self.render_mode = render_mode
        start = self.task.fold.start
        hands = self.task.fold.hands if with_hands else 0
        self._observer = Observer(self.task.garment, start, observation, hands, pixels)
        self.observation_space = self._observer.space
        self._view = View.of_cloth(start)
        self._has_warned = False

    def _warn(self, lines: Sequence[str]) -> None:
        """Give the warnings of the first simulation that has any."""
        for line in () if self._has_warned else lines:
            warnings.warn(line, stacklevel=3)
        self._has_warned |= bool(lines)

    __copy__ = deepcopy  # otherwise both would move the same cloth

    def render(self) -> np.ndarray | None:
        if self.render_mode is None:
            return None
        return self._observer.studio.picture("front", self._view.positions, self._view.seen)


def draw_scenario(disturbances: Disturbances | None, generator: np.random.Generator) -> Scenario:
    """Draw a scenario; without disturbances, it is the nominal one."""
    if disturbances is None:
        return NOMINAL
    return scenarios_of(disturbances, [generator.standard_normal(len(CHANNELS))])[0]
