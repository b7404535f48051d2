"""A manipulation: where both hands grasp, the path they follow, when they move and let go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.folding import path
from tatamu.folding.fold import Fold
from tatamu.scene import Cloth, Gripper, Scene, Table

TOP_SPEED = 0.6
"""Fastest that a hand moves [m/s]; folding twice as fast changes folds (De Gusseme and wyffels 2022)."""
PAD = 0.03
"""Width of the finger pad along the edge [m]."""
PINCH = 0.01
"""How far the pad reaches in from the edge [m]."""
WAIT, HOLD, SETTLE = 0.1, 0.4, 1.0
"""Before the hands move, between arriving and opening, and after opening until the fold is scored [s]."""
FRAME_RATE = 60.0
VIA_EVERY = 10
"""The robot's via-points lie this many frames apart (paper, section VI-C)."""


@dataclass(frozen=True)
class Manipulation:
    """One trial as the hands see it. Both hands follow the same path from their own grasp."""

    grasps: tuple[int, int]
    """Grasped vertex of the left and of the right hand."""
    displacement: np.ndarray
    """Path relative to the grasp [m], shape (s, 3), from 0 to the fold's translation."""
    control_points: np.ndarray | None
    """P0..P3 relative to the grasp [m], shape (4, 3); None for a path that is no cubic Bezier."""

    @property
    def trajectory_length(self) -> float:
        """l_x of Eq. (10) [m]."""
        return path.length(self.displacement)

    @property
    def move_seconds(self) -> float:
        """How long the hands move [s], a whole number of frames."""
        return float(np.ceil(path.duration(self.trajectory_length, TOP_SPEED) * FRAME_RATE) / FRAME_RATE)

    @property
    def timing(self) -> dict[str, float]:
        """When the hands close, start, arrive and open, and when the scene ends [s]."""
        arrives = WAIT + self.move_seconds
        return {
            "closes": 0.0,
            "starts": WAIT,
            "arrives": round(arrives, 9),
            "opens": round(arrives + HOLD, 9),
            "ends": round(arrives + HOLD + SETTLE, 9),
            "top_speed": TOP_SPEED,
        }

    def motion(self) -> tuple[np.ndarray, np.ndarray]:
        """Knots of the hands' motion, one per frame: times [s], shape (k,), displacements [m], shape (k, 3)."""
        count = round(self.move_seconds * FRAME_RATE)
        fraction = path.minimum_jerk(np.arange(count + 1) / count)
        return WAIT + np.arange(count + 1) / FRAME_RATE, path.along(self.displacement, fraction)


def bezier_manipulation(
    fold: Fold, grasps: tuple[int, int], x1: float, z1: float, x2: float, z2: float
) -> Manipulation:
    """The paper's manipulation, Eq. (9): P1 and P2 are given relative to P0, x along the fold, z up [m]."""
    across = np.array([*fold.normal, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    points = np.stack([np.zeros(3), x1 * across + z1 * up, x2 * across + z2 * up, fold.translation])
    return Manipulation(grasps, path.sampled_bezier(points), points)


def patch(fold: Fold, vertex: int) -> list[int]:
    """Vertices that a finger pad covers when it pinches the edge at a vertex; on a coarse mesh its neighbours too."""
    offset = np.abs(fold.garment.vertices[:, :2] - fold.garment.vertices[vertex, :2])
    inwards = offset @ np.abs(fold.normal)
    sideways = offset @ np.abs(fold.normal[::-1])
    return np.flatnonzero((sideways <= max(PAD / 2, 1.3 * fold.garment.spacing)) & (inwards <= PINCH + 1e-9)).tolist()


def scene_of(fold: Fold, manipulation: Manipulation) -> Scene:
    """The scene of one trial: the garment flat on the table, two hands."""
    garment, timing = fold.garment, manipulation.timing
    times, displacements = manipulation.motion()
    grippers = [
        Gripper(
            vertices=patch(fold, vertex),
            closes=timing["closes"],
            opens=timing["opens"],
            times=times.tolist(),
            displacements=displacements,
        )
        for vertex in manipulation.grasps
    ]
    return Scene(
        cloth=Cloth(vertices=garment.vertices, faces=garment.faces, seams=garment.seams),
        material=garment.material,
        table=Table(),
        grippers=grippers,
        duration=timing["ends"],
        frame_rate=FRAME_RATE,
    )


def described(fold: Fold, manipulation: Manipulation) -> dict[str, Any]:
    """What `manipulation.json` holds; see docs/result-folder.md."""
    times, displacements = manipulation.motion()
    via = np.unique(np.append(np.arange(0, len(times), VIA_EVERY), len(times) - 1))
    arms: list[dict[str, Any]] = []
    for name, vertex in zip(("left", "right"), manipulation.grasps, strict=True):
        grasp = fold.garment.vertices[vertex]
        points = manipulation.control_points
        arms.append(
            {
                "name": name,
                "grasp": {"vertex": int(vertex), "position": grasp.tolist(), "patch": patch(fold, vertex)},
                "control_points": None if points is None else (grasp + points).tolist(),
            }
        )
    paths = {arm["name"]: (np.array(arm["grasp"]["position"]) + displacements[via]).tolist() for arm in arms}
    return {
        "version": 1,
        "frame_rate": FRAME_RATE,
        "arms": arms,
        "timing": manipulation.timing,
        "via_points": {"every_frames": VIA_EVERY, "times": times[via].tolist(), **paths},
    }
