"""Simulates a sheet of cloth that hangs from the moving bar of a recording."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from studies.real_cloth.pendulum import AirLaw
from studies.real_cloth.recording import Recording
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene

SIDE = 0.3
"""Side of the square cloth that a robot swings [m]."""
SPACING = 0.02
"""Edge length ("spacing") of the mesh of the simulated cloth [m]."""
DENSITY = 0.2
"""Assumed areal density of the cloth [kg/m^2]. The choice does not matter, because only ratios to the density affect
the motion."""
STRETCH, BENDING = 200.0, 2e-5
"""Stretch stiffness [N/m] and bending rigidity [N m] of the cloth, which do not affect the swing."""
FRAMES = 50.0
"""Number of frames per second of the simulation."""
KNOT = 2
"""Number of time steps of the recorded path between two points of the path that the simulated hand follows."""


@dataclass(frozen=True)
class Sheet:
    """A sheet of simulated cloth that moves as in a recording."""

    recording: Recording

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Vertices along the bar and down, in sides of the sheet, shape (n, 2), and triangles."""
        flat, faces = staggered_rectangle(SIDE, SIDE, SPACING)
        return np.column_stack([flat[:, 1] / SIDE + 0.5, 0.5 - flat[:, 0] / SIDE]), faces

    def scene(self, air: AirLaw) -> Scene:
        """Return a scene in which the sheet first hangs at rest from a bar. Then the bar moves as in the recording."""
        times, corners = self.recording.path
        parts, faces = self.mesh
        held = np.flatnonzero(parts[:, 1] < 1e-9)
        knots = slice(None, None, KNOT)
        start = corners[0]
        hung = start[0] + parts[:, :1] * (start[1] - start[0]) - parts[:, 1:] * [0.0, 0.0, SIDE]
        paths = corners[knots, 0, None] + parts[held, :1] * (corners[knots, 1] - corners[knots, 0])[:, None]
        clock = times[knots] - times[0]
        return Scene(
            cloth=Cloth(vertices=hung, faces=faces),
            material=material(air),
            grippers=[
                Gripper(vertices=[int(vertex)], times=clock.tolist(), displacements=paths[:, k] - hung[vertex])
                for k, vertex in enumerate(held)
            ],
            duration=float(clock[-1]),
            frame_rate=FRAMES,
        )

    def nodes(self, rollout: Rollout, late: float = 0.0) -> np.ndarray:
        """Return the simulated positions, `late` seconds later, of the camera's nodes [m], shape (f, n, n, 3)."""
        moment = self.recording.clock - self.recording.path[0][0] - late
        frame = np.clip(moment * FRAMES, 0.0, len(rollout.times) - 1.001)
        before = frame.astype(int)
        part = (frame - before)[:, None, None]
        positions = (1.0 - part) * rollout.positions[before] + part * rollout.positions[before + 1]
        count = self.recording.nodes.shape[1]
        u, v = np.meshgrid(np.linspace(0.0, 1.0, count), np.linspace(1.0, 0.0, count))
        at = LinearNDInterpolator(self.mesh[0], positions.transpose(1, 0, 2).reshape(len(self.mesh[0]), -1))
        inside = np.clip(np.stack([u, v], axis=-1), 1e-9, 1.0 - 1e-9)
        return np.asarray(at(inside)).reshape(count, count, len(frame), 3).transpose(2, 0, 1, 3)


def material(air: AirLaw) -> Material:
    """Return the material of the cloth, which includes the effects of air (added mass and drag)."""
    return Material(
        areal_density=DENSITY, stretch_stiffness=STRETCH, bending_rigidity=BENDING, thickness=5e-4, **air_fields(air)
    )


def air_fields(air: AirLaw) -> dict[str, float]:
    """Return the fields of a material for air. Linear drag alone takes the field that every simulator has."""
    if air.added_mass == air.quadratic == air.turning == 0.0:
        return {"air_drag": DENSITY * air.linear}
    return {
        "air_drag_normal": DENSITY * air.linear,
        "air_drag_quadratic": DENSITY * air.quadratic,
        "air_drag_turning": DENSITY * air.turning,
        "air_added_mass": DENSITY * air.added_mass,
    }
