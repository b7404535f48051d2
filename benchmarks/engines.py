"""Engines that benchmarks run scenes in: tatamu's simulators, and Newton in a virtual environment of its own."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError, SimulationError
from tatamu.base.files import write_npz
from tatamu.simulation.mesh.topology import Topology, edge_lengths
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Gripper, Scene
from tatamu.simulation.simulators import SIMULATORS, simulate

ENGINES = (*SIMULATORS, "newton")
VARIABLE = "TATAMU_NEWTON"
"""Names a Python that has Newton; else the one that `make bench` installs."""
INSTALLED = Path(__file__).parent.parent / ".venv-newton" / "bin" / "python"
WORKER = Path(__file__).with_name("newton_worker.py")
SUBSTEPS, ITERATIONS = 10, 10
"""Substeps of Newton per frame and iterations per substep, as in its own cloth examples."""


def run(engine: str, scene: Scene) -> Rollout:
    """Run a scene; `info["wall_seconds"]` is the simulation alone.

    Raises:
        InputError: The engine is not installed.
        SimulationError: The rollout failed.
    """
    return newton(scene) if engine == "newton" else simulate(scene, engine)


def newton(scene: Scene, substeps: int = SUBSTEPS, iterations: int = ITERATIONS) -> Rollout:
    """Run a scene over a level table at z = 0 in Newton's SolverVBD, on the processor."""
    python = os.environ.get(VARIABLE, str(INSTALLED))
    if not Path(python).exists():
        raise InputError(
            f"newton: {python} is not there; run `make bench`, or let {VARIABLE} name a Python with Newton"
        )
    with tempfile.TemporaryDirectory() as folder:
        source, out = Path(folder) / "in.npz", Path(folder) / "out.npz"
        write_npz(source, _request(scene, substeps, iterations))
        _call([python, str(WORKER), str(source), str(out)])
        answer = dict(np.load(out))
    if not np.isfinite(answer["positions"]).all():
        raise SimulationError("newton: positions are not finite")
    info = {"simulator": "newton", "version": str(answer["version"]), "wall_seconds": float(answer["seconds"])}
    times = np.arange(scene.frames) / scene.frame_rate
    return Rollout(times, answer["positions"], scene.cloth.faces, info)


def _call(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SimulationError(f"newton: {(done.stderr.strip().splitlines() or ['ended'])[-1]}")


def _request(scene: Scene, substeps: int, iterations: int) -> dict[str, np.ndarray]:
    cloth, step = scene.cloth, 1.0 / (scene.frame_rate * substeps)
    count = (scene.frames - 1) * substeps
    held = np.zeros((len(scene.grippers), len(cloth.vertices)), dtype=bool)
    for row, gripper in zip(held, scene.grippers, strict=True):
        row[gripper.vertices] = True
    numbers = {
        **scene.material.model_dump(),
        "gravity": scene.gravity,
        "edge": float(edge_lengths(cloth.rest, Topology(cloth.faces).edges).mean()),
        "frames": scene.frames,
        "substeps": substeps,
        "iterations": iterations,
        "step": step,
    }
    return {
        "vertices": cloth.vertices,
        "rest": cloth.rest,
        "faces": cloth.faces,
        "held": held,
        "paths": np.array([gripper.path(np.arange(count + 1) * step) for gripper in scene.grippers]),
        "closes": np.array([round(gripper.closes / step) for gripper in scene.grippers]),
        "opens": np.array([_opens(gripper, step, count) for gripper in scene.grippers]),
        "numbers": np.array(json.dumps(numbers)),
    }


def _opens(gripper: Gripper, step: float, count: int) -> int:
    return count + 1 if gripper.opens is None else round(gripper.opens / step)
