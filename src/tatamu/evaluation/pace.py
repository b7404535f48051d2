"""An estimate of the time of one simulation, from its first moments, before any trial has ended."""

from __future__ import annotations

from time import perf_counter

from tatamu.errors import TatamuError
from tatamu.folding.task import Task
from tatamu.folding.trial_scene import scene_of
from tatamu.simulators.native.simulation import Simulation

BEFORE = 0.02
"""Simulated time before the measurement [s]; in it the cloth comes to rest, and kernels are loaded."""
MEASURED = 0.1
"""Simulated time that is measured [s]."""


def simulation_seconds(task: Task) -> float | None:
    """Return a lower bound of the time of one simulation [s]; later contacts between layers take more time.

    Args:
        task: The fold.

    Returns:
        Wall time [s]; None if the task's simulator cannot be stepped, or its simulation fails.
    """
    if task.simulator != "native":
        return None
    scene = scene_of(task.fold, task.manipulation(task.space.middle()))
    if scene.duration < BEFORE + MEASURED:
        return None
    try:
        simulation = Simulation(scene)
        simulation.advance(BEFORE)
        started = perf_counter()
        simulation.advance(MEASURED)
    except TatamuError:
        return None
    return (perf_counter() - started) * scene.duration / MEASURED
