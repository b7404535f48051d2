"""What the viewer in the page is given: cloth and hands at a few frames, in steps of some micrometres."""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.report.fold import LearnedFold
from tatamu.report.packing import motion, packed

FRAMES = 150
"""Most frames of a replay; the viewer moves in straight lines between them."""
BUDGET = 3_000_000
"""Most coordinates in all frames, so that any page stays small; about a byte each when packed."""
STEP = 5e-5
"""Positions are rounded to this [m], or coarser where 65536 steps would not reach across the scene."""
COLOURS = ("left", "right")


def replay(fold: LearnedFold, largest: float) -> dict[str, Any]:
    """The data of the viewer; the last of the packed frames is the target.

    Args:
        fold: The learned fold.
        largest: End of the scale of e_i [m].
    """
    kept = frames(len(fold.rollout.times), len(fold.start))
    shown = np.concatenate([fold.rollout.positions[kept], fold.target[None]])
    low = shown.min(axis=(0, 1))
    step = max(float((shown.max(axis=(0, 1)) - low).max()) / 65535, STEP)
    steps = np.rint((shown - low) / step).astype(np.int64)
    table = fold.scene.table
    return {
        "count": len(fold.start),
        "times": _rounded(fold.rollout.times[kept], 5),
        "low": _rounded(low, 9),
        "step": step,
        "positions": packed(motion(steps)),
        "faces": packed(np.ascontiguousarray(fold.faces, dtype="<u4").tobytes()),
        "largest": largest,
        "hands": _hands(fold, kept),
        "table": table and {"height": table.height, "tilt": table.tilt},
    }


def frames(count: int, vertices: int) -> np.ndarray:
    """Which frames of a rollout to show: the first, the last, and evenly between."""
    most = int(np.clip(BUDGET // (3 * vertices), 2, FRAMES))
    return np.unique(np.rint(np.linspace(0, count - 1, min(count, most))).astype(int))


def _hands(fold: LearnedFold, kept: np.ndarray) -> list[dict[str, Any]]:
    timing = fold.manipulation.timing
    return [
        {
            "colour": colour,
            "path": _rounded(fold.hand(arm)[kept], 5),
            "closes": timing.get("closes", 0.0),
            "opens": timing.get("opens"),
        }
        for colour, arm in zip(COLOURS, fold.manipulation.arms, strict=False)
    ]


def _rounded(values: np.ndarray, digits: int) -> Any:
    return np.round(np.asarray(values, dtype=float), digits).tolist()
