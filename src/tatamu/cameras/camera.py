"""Estimates the camera of a photograph, which converts positions on the table to pixels and back.

The parameters are focal length, centre and two terms of distortion of the lens, the camera's pose relative to the
board's first page, and the position of every further page on the table. They minimise

    sum |seen - projected|^2 / sigma^2  +  sum ((parameter - expected) / deviation)^2

over the board's corners, with the standard error sigma of a pixel, and over the parameters of the lens. The second sum
is a prior. Outside the board, which covers little of the picture, the uncertainty depends mostly on this prior.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from scipy.optimize import OptimizeResult, least_squares

from tatamu.base.errors import InputError
from tatamu.cameras import opencv
from tatamu.cameras.lens import Lens, expected
from tatamu.cameras.pose import Pose

LENS = 5
"""Number of parameters of the lens."""

Seen = tuple[np.ndarray, np.ndarray]
"""Visible corners of a page of the board, in the frame of the page [m] and in the photo [pixels], shape (k, 2) each."""


@dataclass(frozen=True)
class Camera:
    """A camera above a table, which converts positions on the table to pixels and back."""

    matrix: np.ndarray
    """Camera matrix with the focal length and the centre [pixels], shape (3, 3)."""
    distortion: np.ndarray
    """OpenCV's distortion coefficients k1, k2, p1, p2, k3, shape (5,)."""
    turn: np.ndarray
    """Rotation vector from the board's frame to the camera's frame, shape (3,)."""
    shift: np.ndarray
    """Origin of the board's frame in the camera's frame [m], shape (3,)."""

    @cached_property
    def rotation(self) -> np.ndarray:
        """Rotation matrix from the board's frame to the camera's frame, shape (3, 3)."""
        return np.asarray(opencv().Rodrigues(self.turn)[0])

    @property
    def eye(self) -> np.ndarray:
        """Position of the camera in the board's frame [m], shape (3,)."""
        return np.asarray(-self.rotation.T @ self.shift)

    @property
    def tilt(self) -> float:
        """Angle between the camera's optical axis and straight down [rad]."""
        return float(np.arccos(np.clip(-self.rotation[2, 2], -1.0, 1.0)))

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels, shape (n, 2), of points of the board's frame [m], shape (n, 3)."""
        pixels, _ = opencv().projectPoints(
            np.ascontiguousarray(points, dtype=float), self.turn, self.shift, self.matrix, self.distortion
        )
        return np.asarray(pixels)[:, 0]

    def on_table(self, pixels: np.ndarray, height: float | np.ndarray = 0.0) -> np.ndarray:
        """Return the positions on the table [m], shape (n, 2), seen at pixels, shape (n, 2), at a height [m].

        Raises:
            InputError: If a pixel lies above the horizon of the table.
        """
        straight = opencv().undistortPoints(
            np.ascontiguousarray(pixels, dtype=float)[:, None], self.matrix, self.distortion
        )[:, 0]
        rays = np.column_stack([straight, np.ones(len(straight))]) @ self.rotation
        if not (rays[:, 2] < -1e-6).all():
            raise InputError(
                "photo: must be taken from higher up, because the cloth reaches the horizon; tilt the camera down"
            )
        eye = self.eye
        down = (np.broadcast_to(height, len(rays)) - eye[2]) / rays[:, 2]
        return np.asarray(eye[:2] + down[:, None] * rays[:, :2])

    def on_rim(self, outline: np.ndarray, top: float) -> np.ndarray:
        """Return the positions on the table [m] of a cloth's outline in a photo [pixels], shape (n, 2) each.

        The cloth's rim reaches from the table up to `top` [m]. On the near side the outline shows points towards the
        lower edge of the rim, and on the far side towards its upper edge. A hem is round, so these points lie between
        the edges.
        """
        middle = self.on_table(outline, 0.5 * top)
        after, before = np.roll(middle, -2, axis=0), np.roll(middle, 2, axis=0)
        outward = 1.0 if shapely.is_ccw(shapely.LinearRing(middle)) else -1.0
        normals = outward * np.column_stack([(after - before)[:, 1], -(after - before)[:, 0]])
        nearer = self.eye[:2] - middle
        lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(nearer, axis=1)
        facing = (normals * nearer).sum(axis=1) / np.maximum(lengths, 1e-12)
        # 1 would be right for a rim with a square cross-section, 0.3 for a round one
        return self.on_table(outline, 0.5 * top * (1.0 - 0.6 * facing))


@dataclass(frozen=True)
class View:
    """A camera that was estimated from one photograph, with its uncertainty."""

    camera: Camera
    parameters: np.ndarray
    """Parameters of the lens, the camera's pose and the board's further pages, shape (p,)."""
    covariance: np.ndarray
    """Covariance of the parameters, shape (p, p)."""
    rms: float
    """Root mean square error of the board's corners [pixels]."""
    penalty: float
    """The sum that the estimate minimises; smaller is better."""
    lens: Lens | None
    size: tuple[int, int]
    """Width and height of the photograph [pixels]."""

    def varied(self) -> Iterator[Camera]:
        """Yield cameras that differ by one standard deviation in one independent direction of the parameters each.

        The variance of a result is the sum of the squares of its changes with these cameras.
        """
        values, vectors = np.linalg.eigh(self.covariance)
        for value, vector in zip(values, vectors.T, strict=True):
            yield _camera(self.parameters + np.sqrt(max(value, 0.0)) * vector, self.size, self.lens)

    def deviation(self, pixels: np.ndarray, height: float = 0.0) -> np.ndarray:
        """Return the deviations [m] due to the camera, shape (n,), of positions seen at pixels, shape (n, 2)."""
        middle = self.camera.on_table(pixels, height)
        moved = [camera.on_table(pixels, height) - middle for camera in self.varied()]
        return np.sqrt(np.sum(np.square(moved), axis=(0, 2)))

    @property
    def pages(self) -> list[Pose]:
        """Poses of all pages of the board in the frame of the first page."""
        return _poses(self.parameters)


def estimate(
    pages: Sequence[Seen], size: tuple[int, int], lens: Lens | None = None, focal: float | None = None
) -> View:
    """Find the camera of a photo from the corners of a board; the first page defines the board's frame.

    A lens and a focal length that the photo's file states [pixels] are used if they are known.

    Raises:
        InputError: If the corners do not fit a flat board.
    """
    prior, spread = expected(size, lens, focal)

    def residuals(parameters: np.ndarray, sigma: float) -> np.ndarray:
        camera = _camera(parameters, size, lens)
        wrong = [
            (camera.project(_flat(pose.place(points))) - pixels).ravel() / sigma
            for pose, (points, pixels) in zip(_poses(parameters), pages, strict=True)
        ]
        return np.concatenate([*wrong, (parameters[:LENS] - prior) / spread])

    def fit(start: np.ndarray, sigma: float) -> OptimizeResult:
        return least_squares(residuals, start, x_scale="jac", max_nfev=200, args=(sigma,))

    finest = 0.05  # minimum standard error of a corner of the board in the photo [pixels]
    guesses = (1.0, 0.6, 1.6) if lens is None else (1.0,)  # multiples of the expected focal length
    starts = [_start(pages, size, lens, prior + np.array([np.log(guess), 0, 0, 0, 0])) for guess in guesses]
    best = min((fit(start, finest) for start in starts), key=lambda found: found.cost)
    count = sum(len(places) for places, _ in pages)
    rms = float(np.sqrt(np.mean(best.fun[: 2 * count] ** 2))) * finest
    if rms > 5e-4 * max(size):
        raise _not_flat(f"its corners deviate by {rms:.1f} pixels from those of a flat board", lens)
    if rms > finest:  # if the errors of corners are larger, the prior counts more
        best = fit(best.x, rms)
    camera = _camera(best.x, size, lens)
    tilt = float(np.degrees(camera.tilt))
    if tilt > 75.0:
        given = f"given {tilt:.0f} degrees; hold the camera higher"
        raise InputError(f"photo: must be taken at less than 75 degrees from the vertical, {given}")
    # With two pages and a tilt of 15 to 50 degrees, a focal length wrong by 2 % is up to 3 deviations of the lens file
    # away, and one wrong by 10 % is 4 to 12 away.
    away = float(np.abs((best.x[:LENS] - prior) / spread).max())
    if lens is not None and away > 6.0:
        shown = max(size) * float(np.exp(best.x[0]))
        raise InputError(
            f"lens: must have a focal length of about {shown:.0f} pixels to fit the photo, given "
            f"{lens.focal:.0f}; leave --lens out, or make the file again with `tatamu lens`"
        )
    covariance = np.linalg.pinv(best.jac.T @ best.jac, hermitian=True)
    return View(camera, best.x, covariance, rms, float(best.cost), lens, size)


def _start(pages: Sequence[Seen], size: tuple[int, int], lens: Lens | None, optics: np.ndarray) -> np.ndarray:
    """Return start values for the parameters of the lens, the camera's pose and the positions of further pages."""
    cv2 = opencv()
    blank = _camera(np.concatenate([optics, np.zeros(6)]), size, lens)
    points, pixels = pages[0]
    found, turn, shift = cv2.solvePnP(_flat(points), pixels, blank.matrix, blank.distortion, flags=cv2.SOLVEPNP_IPPE)
    if not found:
        raise _not_flat("its corners in the photo do not fit a flat board", lens)
    first = np.concatenate([optics, turn.ravel(), shift.ravel()])
    camera = _camera(first, size, lens)
    others = [Pose.moving(points, camera.on_table(pixels)) for points, pixels in pages[1:]]
    return np.concatenate([first, *([pose.x, pose.y, pose.yaw] for pose in others)])


def _not_flat(why: str, lens: Lens | None) -> InputError:
    wrong_lens = " and leave --lens out, because this lens file may be for another lens" if lens is not None else ""
    return InputError(f"board: must be flat, but {why}; lay the board flat{wrong_lens}")


def _poses(parameters: np.ndarray) -> list[Pose]:
    return [Pose(), *(Pose(*place) for place in parameters[LENS + 6 :].reshape(-1, 3).tolist())]


def _camera(parameters: np.ndarray, size: tuple[int, int], lens: Lens | None) -> Camera:
    longer = max(size)
    logarithm, x, y, k1, k2 = parameters[:LENS]
    focal = longer * np.exp(logarithm)
    matrix = np.array([[focal, 0.0, longer * x], [0.0, focal, longer * y], [0.0, 0.0, 1.0]])
    rest = (*lens.distortion, 0.0, 0.0, 0.0, 0.0, 0.0)[2:5] if lens is not None else (0.0, 0.0, 0.0)
    return Camera(matrix, np.array([k1, k2, *rest]), parameters[LENS : LENS + 3], parameters[LENS + 3 : LENS + 6])


def _flat(points: np.ndarray) -> np.ndarray:
    return np.column_stack([points, np.zeros(len(points))])
