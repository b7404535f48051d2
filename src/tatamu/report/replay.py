"""What the viewer in the page is given: cloth and hands at a few frames, in steps of some micrometres."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from tatamu.report.fold import LearnedFold

FRAMES = 150
"""Most frames of a replay; the viewer moves in straight lines between them."""
BUDGET = 1_600_000
"""Most bytes of all positions, so that a page stays small whatever the mesh; text takes a third more."""
COLOURS = ("left", "right")


def replay(fold: LearnedFold, largest: float) -> dict[str, Any]:
    """The data of the viewer.

    Args:
        fold: The learned fold.
        largest: End of the scale of e_i [m].
    """
    kept = frames(len(fold.rollout.times), len(fold.start))
    shown = np.concatenate([fold.rollout.positions[kept], fold.target[None]])
    low = shown.min(axis=(0, 1))
    step = max(float((shown.max(axis=(0, 1)) - low).max()) / 65535, 1e-9)
    steps = np.rint((shown - low) / step).astype("<u2")
    table = fold.scene.table
    return {
        "count": len(fold.start),
        "times": _rounded(fold.rollout.times[kept], 5),
        "low": _rounded(low, 9),
        "step": step,
        "positions": _text(steps[:-1]),
        "target": _text(steps[-1]),
        "faces": _text(fold.faces.astype("<u4")),
        "errors": _rounded(fold.errors, 6),
        "largest": largest,
        "hands": _hands(fold, kept),
        "table": table and {"height": table.height, "tilt": table.tilt},
    }


def frames(count: int, vertices: int) -> np.ndarray:
    """Which frames of a rollout to show: the first, the last, and evenly between."""
    most = int(np.clip(BUDGET // (6 * vertices), 2, FRAMES))
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


def _text(values: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()
