"""A rollout: the motion that a simulator computes from a scene."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.files import foreign, read_npz, write_npz


@dataclass(frozen=True)
class Rollout:
    """Positions of the cloth over time. Frame 0 is the start."""

    times: np.ndarray
    """Time of each frame [s], shape (f,)."""
    positions: np.ndarray
    """Position of each vertex in each frame [m], shape (f, n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3)."""
    info: dict[str, Any]
    """Metadata with the keys simulator, version, wall_seconds, setup_seconds, steps, warnings."""
    extra: dict[str, np.ndarray] = field(default_factory=dict)
    """Additional arrays in the same file, such as the target shape `target`, shape (n, 3)."""

    def __repr__(self) -> str:
        simulator = self.info.get("simulator", "unknown")
        return (
            f"<Rollout of {self.positions.shape[1]} vertices: {len(self.times)} frames to {self.times[-1]:.2f} s, "
            f"simulator {simulator}>"
        )

    def save(self, path: Path | str) -> None:
        """Write the rollout to an .npz file without pickles."""
        arrays = {"times": self.times, "positions": self.positions, "faces": self.faces, **self.extra}
        write_npz(Path(path), {**arrays, "info": np.array(json.dumps(self.info))})

    @classmethod
    def load(cls, path: Path | str) -> Rollout:
        """Read a rollout from an .npz file, or raise InputError."""
        arrays = read_npz(Path(path), "a rollout file")
        with foreign(Path(path), "a rollout file"):
            info = json.loads(str(arrays.pop("info")))
            times, positions, faces = (arrays.pop(name) for name in ("times", "positions", "faces"))
            _check(times, positions, faces)
            if any(array.dtype.kind == "U" for array in arrays.values()):
                raise ValueError("info must be the only array of text")
            if not isinstance(info, dict):
                raise ValueError("info must be a JSON object")
            return cls(times, positions, faces, info, arrays)


def _check(times: np.ndarray, positions: np.ndarray, faces: np.ndarray) -> None:
    if (times.ndim, positions.ndim, faces.ndim) != (1, 3, 2):
        raise ValueError("times must have 1 dimension, positions 3, and faces 2")
    if times.dtype.kind != "f" or positions.dtype.kind != "f" or faces.dtype.kind not in "iu":
        raise ValueError("times and positions must be floating point numbers, and faces integers")
    if positions.shape != (len(times), positions.shape[1], 3) or not len(times) or faces.shape[1] != 3:
        raise ValueError("positions must have x, y, z of each vertex at each time, and faces must have 3 vertices each")
    if not (np.isfinite(times).all() and np.isfinite(positions).all()):
        raise ValueError("times and positions must be finite")
    if not 0 <= faces.min(initial=0) <= faces.max(initial=0) < positions.shape[1]:
        raise ValueError(f"faces must be vertex indices from 0 to {positions.shape[1] - 1}")
