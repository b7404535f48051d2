"""A rollout: the motion that a simulator computes of a scene."""

from __future__ import annotations

import json
import zipfile
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.errors import InputError
from tatamu.files import write_npz


@dataclass(frozen=True)
class Rollout:
    """Positions of the cloth over time; frame 0 is the start."""

    times: np.ndarray
    """Time of each frame [s], shape (f,)."""
    positions: np.ndarray
    """Vertex positions [m], shape (f, n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3)."""
    info: dict[str, Any]
    """The keys simulator, version, wall_seconds, setup_seconds, steps, warnings."""
    extra: dict[str, np.ndarray] = field(default_factory=dict)
    """Further arrays in the same file, such as `target`, shape (n, 3)."""

    def save(self, path: Path | str) -> None:
        """Write the .npz; nothing in it is pickled."""
        arrays = {"times": self.times, "positions": self.positions, "faces": self.faces, **self.extra}
        write_npz(Path(path), {**arrays, "info": np.array(json.dumps(self.info))})

    @classmethod
    def load(cls, path: Path | str) -> Rollout:
        """Read a rollout.

        Raises:
            InputError: The file cannot be read or is not a rollout.
        """
        try:
            with np.load(path, allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in archive.files}
            info = json.loads(str(arrays.pop("info")))
            times, positions, faces = (arrays.pop(name) for name in ("times", "positions", "faces"))
            if (times.ndim, positions.ndim, faces.ndim) != (1, 3, 2) or not isinstance(info, dict):
                raise ValueError("times, positions, faces must have 1, 3, 2 dimensions, info must be an object")
            return cls(times, positions, faces, info, arrays)
        except OSError as error:
            raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
        except (KeyError, TypeError, ValueError, EOFError, zlib.error, zipfile.BadZipFile) as error:
            raise InputError(f"{path}: is not a rollout file ({error})") from None
