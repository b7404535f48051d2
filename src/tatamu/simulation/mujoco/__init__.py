"""The simulator MuJoCo, with its deformable bodies (flex). See docs/theory/mujoco.md."""

from __future__ import annotations

import time
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.simulation.mesh.topology import Topology, edge_lengths
from tatamu.simulation.mujoco.controlled import HeldVertices, MovingBody
from tatamu.simulation.mujoco.model import compiled, engine, vertex_masses
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene, Segment, segments
from tatamu.simulation.side_by_side import side_by_side
from tatamu.simulation.simulators import Capabilities

CAPABILITIES = Capabilities(parallel=True, bodies=True, sound_cell=0.37, usable_cell=0.45)
"""Bending energy is quadratic, so a fold collapses into a flat crease if edges are longer than 0.37 bending lengths.

A rehearsal compares two folds on the same mesh, so up to 0.45 is accepted there, because each halving of the edges
would need four times as many vertices (docs/theory/robot-planning.md)."""


def require() -> None:
    """Raise InputError if MuJoCo is not installed, or is too old."""
    engine()


def prepare() -> None:
    """Do nothing, because MuJoCo is imported with the first scene."""


def compilation() -> tuple[int, int]:
    """Return (0, 0), because no function is compiled."""
    return 0, 0


def simulate(scene: Scene) -> Rollout:
    """Simulate one scene, or raise SimulationError if the rollout is not finite."""
    begin = time.perf_counter()
    run = Run(scene)
    ready = time.perf_counter()
    positions = run.positions()
    info = {
        "simulator": "mujoco",
        "version": engine().__version__,
        "wall_seconds": time.perf_counter() - ready,
        "setup_seconds": ready - begin,
        "steps": run.steps,
        "warnings": run.warnings(),
    }
    return Rollout(np.arange(scene.frames) / scene.frame_rate, positions, scene.cloth.faces, info)


class Run:
    """A running simulation: MuJoCo's model and state, and the hands."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.model = compiled(scene)
        self.data = engine().MjData(self.model)
        self.sliders = 3 * len(scene.cloth.vertices)
        self.data.qpos[: self.sliders] = (scene.cloth.vertices - scene.cloth.rest).ravel()
        self.scratch = engine().MjData(self.model)
        self.hands = [HeldVertices(gripper, vertex_masses(scene)) for gripper in scene.grippers]
        bodies = [MovingBody(body, self.model, number) for number, body in enumerate(scene.bodies)]
        self.controlled: list[HeldVertices | MovingBody] = [*self.hands, *bodies]
        self.steps = 0

    def positions(self) -> np.ndarray:
        """Simulate the whole scene, and return the positions in all frames [m], shape (f, n, 3)."""
        frames = [self.scene.cloth.vertices]
        before: tuple[object, ...] = ()
        for segment in segments(self.scene, np.inf):
            pieces = max(1, int(np.ceil(segment.duration / 2e-3 - 1e-6)))  # steps of at most 2 ms
            situation = (round(segment.duration / pieces, 12), segment.held)
            if situation != before:
                self._change(*situation)
                before = situation
            self._through(segment, pieces)
            if segment.frame:
                frames.append(self._now(segment.end))
        return np.array(frames)

    def _change(self, step: float, held: tuple[bool, ...]) -> None:
        """Change the time step or the held vertices, on which the factorised matrix of mass and stiffness depends."""
        for hand, holding in zip(self.hands, held, strict=True):
            if not holding:
                hand.open(self.model)
        for hand, holding in zip(self.hands, held, strict=True):
            if holding:
                hand.close(self.model, self.data)
        self.model.opt.timestep = step
        engine().mj_setConst(self.model, self.scratch)

    def _through(self, segment: Segment, pieces: int) -> None:
        for start, end in pairwise(np.linspace(segment.start, segment.end, pieces + 1).tolist()):
            for each in self.controlled:
                each.aim(self.data, start, end)
            engine().mj_step(self.model, self.data)
            for each in self.controlled:
                each.settle(self.data, end)
        self.steps += pieces

    def _now(self, time: float) -> np.ndarray:
        positions = self.scene.cloth.rest + self.data.qpos[: self.sliders].reshape(-1, 3)
        names = engine().mjtWarning
        lost = any(self.data.warning[int(name)].number for name in (names.mjWARN_BADQPOS, names.mjWARN_BADQVEL))
        if lost or not np.isfinite(positions).all():
            raise SimulationError(f"mujoco: positions are no longer finite after {time:.3g} s")
        return np.asarray(positions)

    def warnings(self) -> list[str]:
        """Return MuJoCo's own warnings, and a line for each property that it cannot represent."""
        names = engine().mjtWarning
        found = [
            f"mujoco: {names(number).name.removeprefix('mjWARN_').lower()}, {warning.number} times"
            for number, warning in enumerate(self.data.warning)
            if warning.number
        ]
        if self.scene.material.compression < 1.0:
            found.append("mujoco: compression: ignored, so cloth resists compression as much as tension")
        found += [f"mujoco: {line}" for line in CAPABILITIES.lacking(self.scene.material)]
        cloth, largest = self.scene.cloth, (CAPABILITIES.sound_cell or np.inf) * self.scene.material.bending_length
        spacing = float(edge_lengths(cloth.rest, Topology(cloth.faces).edges).mean())
        if spacing > largest:
            found.append(
                f"mujoco: the triangles are so large ({1e3 * spacing:.0f} mm) that folds become flat creases; give a "
                f"spacing of at most {1e3 * largest:.0f} mm"
            )
        return found


def simulate_many(scenes: Sequence[Scene]) -> list[Rollout]:
    """Simulate several scenes, with one thread per processor core."""
    return side_by_side(simulate, scenes)
