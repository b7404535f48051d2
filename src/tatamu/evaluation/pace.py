"""An estimate of the time of one simulation, which is made before any trial has ended.

Only the start of a simulation is measured.
"""

from __future__ import annotations

from time import perf_counter

from tatamu.base.errors import TatamuError
from tatamu.folding.task import Task
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.native.simulation import Simulation

BEFORE = 0.02
"""Simulated time before the pace of a simulation is measured [s].

During this time the cloth comes to rest, and compiled code is loaded.
"""
MEASURED = 0.1
"""Simulated time during which the pace of a simulation is measured [s]."""


def simulation_seconds(task: Task) -> float | None:
    """Return a lower bound of the wall time of one simulation [s].

    Later in the simulation, layers touch each other and take more time.

    Args:
        task: The fold to simulate.

    Returns:
        Wall time [s]; None if the task's simulator cannot be stepped or its simulation fails.
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
