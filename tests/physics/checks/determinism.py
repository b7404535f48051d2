"""Checks of determinism: a scene gives the same bytes when it is repeated, in another process, and in a batch."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import SIMULATORS
from tests.physics.check import Case, Check
from tests.physics.checks.symmetry import carried, folded
from tests.physics.findings import Findings, small
from tests.physics.subject import Subject


def different(first: Rollout, second: Rollout) -> float:
    """Return the number of different bytes in the positions of two rollouts, which are simulated motions.

    If the numbers of positions differ, all bytes count as different.
    """
    a = first.positions.tobytes()
    b = second.positions.tobytes()
    if len(a) != len(b):
        return float(max(len(a), len(b)))
    return float((np.frombuffer(a, np.uint8) != np.frombuffer(b, np.uint8)).sum())


def again(subject: Subject) -> Findings:
    """Compare two rollouts of one scene in this process. Between the two simulations, another scene is simulated."""
    scene = folded()
    first = subject.simulate(scene)
    subject.simulate(carried())
    second = subject.simulate(scene)
    yield small("bytes that differ", different(first, second), subject.limit("bytes"), "-")


def elsewhere(subject: Subject) -> Findings:
    """Compare a rollout in this process with a rollout in another process."""
    if subject.name not in SIMULATORS:
        return
    scene = folded()
    first = subject.simulate(scene)
    second = in_another_process(scene, subject.name)
    yield small("bytes that differ", different(first, second), subject.limit("bytes"), "-")


def in_another_process(scene: Scene, simulator: str) -> Rollout:
    """Simulate a scene in another process, with the command line, and return the rollout."""
    with TemporaryDirectory() as folder:
        given = Path(folder) / "scene.json"
        made = Path(folder) / "rollout.npz"
        scene.save(given)
        command = "import sys; from tatamu.cli import main; sys.argv[0] = 'tatamu'; main()"
        arguments = ["simulate", str(given), "--out", str(made), "--simulator", simulator]
        done = subprocess.run([sys.executable, "-c", command, *arguments], capture_output=True, text=True, check=False)
        if done.returncode:
            raise SimulationError(f"the other process failed: {done.stderr.strip()[-200:]}")
        return Rollout.load(made)


def batch(subject: Subject) -> Findings:
    """Compare scenes that are simulated one by one with scenes that `simulate_many` simulates together."""
    scenes = [folded(), carried(), folded()]
    together = subject.simulate_many(scenes)
    alone = [subject.simulate(scene) for scene in scenes[:2]]
    count = sum(different(together[k], alone[k % 2]) for k in range(3))
    yield small("bytes that differ", count, subject.limit("bytes"), "-")


CHECKS = (
    Check(
        "determinism",
        "The same scene twice",
        "the same bytes",
        (Case("in one process", again), Case("in two processes", elsewhere), Case("in a batch", batch)),
    ),
)
