"""Folders of learned folds, made up: two hands 0.30 m apart carry a towel's edge over, with smooth timing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.folding.manipulation import Course, Manipulation

SPEED = 0.6
"""Of the faster hand [m/s]."""


def bezier(control: np.ndarray, u: np.ndarray) -> np.ndarray:
    """A cubic Bezier curve, written out apart from the package's: (4, 3) and (n,) to (n, 3)."""
    return np.array([sum(c * w for c, w in zip(control, _weights(x), strict=True)) for x in u])


def _weights(u: float) -> tuple[float, ...]:
    v = 1 - u
    return v**3, 3 * v * v * u, 3 * v * u * u, u**3


def _inner(span: float, height: float) -> np.ndarray:
    """P0..P3 from the grasp [m], shape (4, 3)."""
    return np.array([[0, 0, 0], [0.1 * span, 0, height], [0.8 * span, 0, height], [span, 0, 0.001]])


def manipulation(
    span: float = 0.34,
    width: float = 0.30,
    height: float = 0.15,
    shift: float = 0.0,
    lift: float = 0.0,
) -> dict[str, Any]:
    """manipulation.json of a fold over `span` metres, its middle at x = `shift`, by hands with fingers `lift` thick."""
    rate, every, starts = 60, 10, 0.1
    grasp = np.array([shift - span / 2, 0.0, 0.0005 + lift])
    places = np.linspace(0, 1, 2001)
    curve = bezier(grasp + _inner(span, height), places)
    travelled = np.append(0.0, np.linalg.norm(np.diff(curve, axis=0), axis=1).cumsum())
    duration = np.ceil(1.875 * travelled[-1] / SPEED * rate) / rate  # minimum jerk is 1.875 times as fast as on average
    arrives = starts + duration
    times = np.append(np.arange(starts, arrives - 1e-6, every / rate), arrives)
    s = np.clip((times - starts) / duration, 0, 1)
    u = np.interp(s**3 * (10 - 15 * s + 6 * s * s), travelled / travelled[-1], places)
    arms, via = [], {}
    for name, y in (("left", width / 2), ("right", -width / 2)):
        grasp = np.array([shift - span / 2, y, 0.0005])
        begin = grasp + np.array([0.0, 0.0, lift])
        control = begin + _inner(span, height)
        via[name] = bezier(control, u).tolist()
        arms.append(
            {
                "name": name,
                "grasp": {"vertex": 0, "position": grasp.tolist(), "patch": [0]},
                "control_points": control.tolist(),
            }
        )
    timing = {"closes": 0.0, "starts": starts, "arrives": arrives, "opens": arrives + 0.4, "ends": arrives + 1.4}
    return {
        "version": 1,
        "frame_rate": rate,
        "arms": arms,
        "timing": {**timing, "top_speed": SPEED},
        "via_points": {"every_frames": every, "times": times.tolist(), **via},
    }


def exact(span: float = 0.34, width: float = 0.30, height: float = 0.15, shift: float = 0.0) -> Manipulation:
    """The same fold as `manipulation`, at the speed of tatamu's own trials."""
    control = _inner(span, height)
    places = [np.array([shift - span / 2, y, 0.0005]) for y in (width / 2, -width / 2)]
    return Manipulation(tuple(Course.on_curve(vertex, place, control) for vertex, place in enumerate(places)))


def folder(path: Path, **fold: float) -> Path:
    """A learned fold's folder with what a plan reads."""
    path.mkdir(parents=True, exist_ok=True)
    (path / "manipulation.json").write_text(json.dumps(manipulation(**fold)))
    return path
