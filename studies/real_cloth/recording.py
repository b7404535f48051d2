"""Reads recordings of a cloth that a robot moves.

They are by Luque et al. (Institut de Robotica i Informatica Industrial, Barcelona). A square cloth hangs by its upper
edge from a bar in the robot's hand. A camera records a grid of nodes on the cloth at about 10 Hz. The robot records the
pose of its tool at 20 Hz. The camera lags by about 0.3 s, and the lag varies by some tens of milliseconds between
frames. Because the camera's times are inexact, the robot's poses drive the simulation. The time of each frame is then
corrected. With the corrected time, the camera sees the two upper corners of the cloth where the robot holds them.
"""

from __future__ import annotations

import zipfile
import zlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation, Slerp

from tatamu.base.errors import InputError

LAGS = np.arange(0.1, 0.6, 0.02)
"""Lags of the camera behind the robot that are tried [s]."""
CLOCKS = np.arange(-0.15, 0.151, 0.01)
"""Corrections of the time of a camera frame that are tried [s]."""
JITTER = 0.05
"""Standard deviation of the camera's lag from frame to frame [s]."""
CORNER_NOISE = 0.008
"""Standard deviation of the position of a corner of the cloth that the camera sees [m]."""
OUTLIER = 0.04
"""Largest distance between a node of the cloth and its median position in five frames [m]. A node at a larger distance
is an outlier of the camera."""
SMOOTHING = 0.05
"""Standard deviation of the Gaussian filter that smooths the robot's path [s]."""
STEP = 0.01
"""Time step of the robot's smoothed path [s]."""
BEFORE = 1.0
"""Time for which the robot is assumed to rest before the recording begins [s]."""


@dataclass(frozen=True)
class Recording:
    """A recorded motion of the robot, and the nodes of the cloth that the camera saw."""

    name: str
    times: np.ndarray
    """Times of the camera's f frames, on the camera's clock [s], shape (f,)."""
    nodes: np.ndarray
    """Positions of the cloth's n x n nodes at each of the camera's f frames [m], shape (f, n, n, 3). Row 0 is the lower
    edge, and the last row is the held edge. A node that the camera lost is NaN."""
    tool_times: np.ndarray
    """Times at which the k poses of the robot's tool were recorded [s], shape (k,), increasing."""
    tool_positions: np.ndarray
    """Positions of the robot's tool [m], shape (k, 3)."""
    tool_rotations: np.ndarray
    """Rotations of the robot's tool as quaternions (x, y, z, w), shape (k, 4)."""

    @cached_property
    def _turned(self) -> Slerp:
        return Slerp(self.tool_times, Rotation.from_quat(self.tool_rotations))

    def pose(self, times: np.ndarray) -> tuple[np.ndarray, Rotation]:
        """Return the positions and rotations of the tool at given times [s]. Before and after the record it rests."""
        inside = np.clip(times, self.tool_times[0], self.tool_times[-1])
        position = np.column_stack([np.interp(inside, self.tool_times, column) for column in self.tool_positions.T])
        return position, self._turned(inside)

    @cached_property
    def grip(self) -> tuple[float, np.ndarray]:
        """Lag of the camera [s], and positions of the cloth's upper corners in the tool's frame [m], shape (2, 3)."""
        corners = self.nodes[:, -1, [0, -1]]
        seen = np.isfinite(corners).all(axis=(1, 2))
        best = (np.inf, 0.0, np.zeros((2, 3)))
        for lag in LAGS:
            position, rotation = self.pose(self.times[seen] - lag)
            inside = np.stack([rotation.inv().apply(corners[seen, k] - position) for k in (0, 1)], axis=1)
            held = np.median(inside, axis=0)
            off = float(np.minimum(np.linalg.norm(inside - held, axis=2), OUTLIER).mean())
            if off < best[0]:
                best = (off, float(lag), held)
        return best[1], best[2]

    @cached_property
    def clock(self) -> np.ndarray:
        """Corrected time of each of the camera's f frames, on the robot's clock [s], shape (f,)."""
        lag, _ = self.grip
        costs = []
        for offset in CLOCKS:
            off = np.linalg.norm(self.corners(self.times - lag + offset) - self.nodes[:, -1, [0, -1]], axis=2)
            off = np.minimum(np.nan_to_num(off, nan=OUTLIER), OUTLIER)  # an outlier does not help to find the time
            costs.append((off**2).sum(axis=1) / CORNER_NOISE**2 + (offset / JITTER) ** 2)
        return np.asarray(self.times - lag + CLOCKS[np.argmin(costs, axis=0)])

    def corners(self, times: np.ndarray) -> np.ndarray:
        """Return the cloth's two upper corners at k times, by the robot's poses [m], shape (k, 2, 3)."""
        position, rotation = self.pose(times)
        held = self.grip[1]
        return np.stack([position + rotation.apply(held[k]) for k in (0, 1)], axis=1)

    def normal(self, times: np.ndarray) -> np.ndarray:
        """Return the horizontal unit vector across the bar that holds the cloth, at k times [s], shape (k, 3)."""
        corners = self.corners(times)
        along = corners[:, 1] - corners[:, 0]
        across = np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(along))])
        return across / np.linalg.norm(across, axis=1)[:, None]

    @cached_property
    def path(self) -> tuple[np.ndarray, np.ndarray]:
        """Smoothed path of the bar that holds the cloth: k times [s], and both ends of the bar [m], shape (k, 2, 3)."""
        times = np.arange(self.clock.min() - BEFORE, self.clock.max() + 2 * STEP, STEP)
        return times, gaussian_filter1d(self.corners(times), SMOOTHING / STEP, axis=0, mode="nearest")

    @cached_property
    def middle(self) -> np.ndarray:
        """Middle of the bar that holds the cloth at the camera's f frames [m], shape (f, 1, 1, 3)."""
        return np.asarray(self.corners(self.clock).mean(axis=1)[:, None, None])

    @cached_property
    def good(self) -> np.ndarray:
        """Whether the camera neither lost nor misplaced each node at each of f frames, shape (f, n, n)."""
        from_bar = self.nodes - self.middle
        padded = np.pad(from_bar, ((2, 2), (0, 0), (0, 0), (0, 0)), mode="edge")
        near = np.stack([padded[k : k + len(from_bar)] for k in range(5)])
        usual = np.nanmedian(np.where(np.isfinite(near), near, np.nan), axis=0)
        return np.asarray(np.linalg.norm(from_bar - usual, axis=3) <= OUTLIER)

    def swing_of(self, nodes: np.ndarray) -> np.ndarray:
        """Return the horizontal distance between lower and upper edge across the bar at f frames [m], shape (f,)."""
        apart = self._edge(nodes, 0) - self._edge(nodes, -1)
        return np.asarray((apart * self.normal(self.clock)).sum(axis=1))

    def _edge(self, nodes: np.ndarray, row: int) -> np.ndarray:
        """Return the mean position of a row's good nodes at f frames [m], NaN without any, shape (f, 3)."""
        good = self.good[:, row, :, None]
        count = np.where(good.any(axis=1), good.sum(axis=1), np.nan)
        return np.asarray(np.where(good, nodes[:, row], 0.0).sum(axis=1) / count)

    @cached_property
    def swing(self) -> np.ndarray:
        """Measured distance of the lower edge from rest [m], NaN where the camera lost an edge, shape (f,)."""
        measured = self.swing_of(self.nodes)
        return np.asarray(measured - np.nanmedian(measured))

    @cached_property
    def noise(self) -> float:
        """RMS distance between the upper corners as the camera sees them and as the robot holds them [m]."""
        off = np.linalg.norm(self.corners(self.clock) - self.nodes[:, -1, [0, -1]], axis=2)
        return float(np.sqrt(np.mean(off[self.good[:, -1, [0, -1]]] ** 2)))


def load_recordings(path: Path, session: str, left_out: tuple[str, ...]) -> list[Recording]:
    """Read the recordings of a session in which the robot's poses were recorded, except the recordings `left_out`.

    Raises:
        InputError: If the file cannot be read, or contains no such recording.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files if name.startswith(session)}
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except (ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f"{path}: is not an .npz file of numbers ({error})") from None
    names = sorted({name.rsplit("__", 1)[0] for name in arrays if name.endswith("__tcp")})
    wanted = [name for name in names if not any(word in name for word in left_out)]
    if not wanted:
        raise InputError(f"{path}: must hold recordings {session}__NAME__tcp, given none")
    return [_recording(path, name, arrays) for name in wanted]


def _recording(path: Path, name: str, arrays: dict[str, np.ndarray]) -> Recording:
    for part, dimensions, last in (("t", 1, None), ("mesh", 4, 3), ("tcp", 2, 8)):
        array = arrays.get(f"{name}__{part}")
        if array is None or array.ndim != dimensions or (last and array.shape[-1] != last) or len(array) < 5:
            raise InputError(
                f"{path}: {name}__{part}: must have {dimensions} dimensions, given "
                f"{'nothing' if array is None else array.shape}"
            )
    tool = arrays[f"{name}__tcp"].astype(float)
    _, once = np.unique(tool[:, 0], return_index=True)
    return Recording(
        name.split("__")[1],
        arrays[f"{name}__t"].astype(float),
        arrays[f"{name}__mesh"].astype(float),
        tool[once, 0],
        tool[once, 1:4],
        tool[once, 4:],
    )
