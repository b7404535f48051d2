"""Makes the data of a replay in a page: cloth and hands in a few frames, with rounded positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.show.page import packed
from tatamu.show.solids import MovingMesh, moving, together
from tatamu.simulation.mesh.topology import facing_down
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene

FRAMES = 150
"""Largest number of frames of a replay; the viewer interpolates linearly between the frames."""
BUDGET = 3_000_000
"""Largest number of coordinates in all frames of a replay; each takes about a byte of the page."""
STEP = 5e-5
"""Length to whose multiples positions are rounded [m]; a larger one in a scene above 65536 times this length."""
HAND_COLOURS = ("left", "right")
"""Names of the colours of the two hands."""


@dataclass(frozen=True)
class HandTrack:
    """The motion of a hand in a replay."""

    colour: str
    """Name of the hand's colour."""
    path: np.ndarray
    """Position of the hand in each frame [m], shape (f, 3)."""
    holds: list[tuple[float, float | None]]
    """Times at which the hand closes and opens again (None if it does not), for each grasp [s]."""


def replay_data(
    rollout: Rollout, scene: Scene, hands: list[HandTrack], largest: float, robot: MovingMesh | None = None
) -> dict[str, Any]:
    """Return the data with which the viewer replays a rollout.

    Args:
        rollout: Motion of the cloth, with the target in `extra["target"]`.
        scene: Scene of the motion, with its rigid bodies.
        hands: Motions of the hands.
        largest: End of the colour scale for vertex errors [m].
        robot: Meshes of the robot's links at each frame of the rollout; None if no robot is drawn.
    """
    kept = frames(len(rollout.times), len(rollout.positions[0]))
    table = scene.table
    solid = together(robot, moving(scene.bodies, rollout.times))
    lower = facing_down(scene.cloth.rest, rollout.faces)
    return {
        **_packed(rollout.positions[kept], rollout.extra["target"], rollout.faces[np.argsort(lower, kind="stable")]),
        "upper": int((~lower).sum()),
        "layers": 2 if lower.any() else 1,
        "times": _rounded(rollout.times[kept], 5),
        "largest": largest,
        "hands": [{"colour": hand.colour, "path": _rounded(hand.path[kept], 5), "holds": hand.holds} for hand in hands],
        "table": table and {"height": table.height, "tilt": table.tilt},
        **({"robot": _packed(solid[0][kept], solid[0][-1], solid[1])} if solid else {}),
    }


def _packed(positions: np.ndarray, last: np.ndarray, faces: np.ndarray) -> dict[str, Any]:
    """Return the compressed positions of a mesh in f frames, shape (f, n, 3), and in one more shape, and its triangles.

    Positions are whole numbers of `STEP`, measured from the corner with the smallest coordinates.
    """
    shown = np.concatenate([positions, last[None]])
    low = shown.min(axis=(0, 1))
    step = max(float((shown.max(axis=(0, 1)) - low).max()) / 65535, STEP)
    return {
        "count": len(last),
        "low": _rounded(low, 9),
        "step": step,
        "positions": packed(motion(np.rint((shown - low) / step).astype(np.int64))),
        "faces": packed(np.ascontiguousarray(faces, dtype="<u4").tobytes()),
    }


def motion(steps: np.ndarray) -> bytes:
    """Return numbers that change smoothly from frame to frame as bytes that can be compressed well.

    The numbers are whole, from 0 to 65535, shape (f, ..) for f frames. Stored is the difference from a straight line
    through the two frames before, modulo 65536 and zigzag coded: first all low bytes, then all high bytes.
    """
    wide = np.zeros((len(steps) + 2, *steps.shape[1:]), dtype=np.int64)
    wide[2:] = steps
    off = (wide[2:] - 2 * wide[1:-1] + wide[:-2]).astype(np.int16)
    folded = ((off << 1) ^ (off >> 15)).view(np.uint16).ravel()
    return bytes((folded & 255).astype(np.uint8)) + bytes((folded >> 8).astype(np.uint8))


def frames(count: int, vertices: int) -> np.ndarray:
    """Return the frames of a rollout that a replay shows: the first, the last, and at equal intervals between."""
    most = int(np.clip(BUDGET // (3 * vertices), 2, FRAMES))
    return np.unique(np.rint(np.linspace(0, count - 1, min(count, most))).astype(int))


def _rounded(values: np.ndarray, digits: int) -> Any:
    return np.round(np.asarray(values, dtype=float), digits).tolist()
