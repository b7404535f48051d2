"""Reads a finished fold from a photograph: where the moved hem lies, and how far the lower hem has slipped.

The moved hem lies on the opposite, lower hem. If an edge is seen inside the outline, it is the moved hem, and the
outline shows the lower hem. Otherwise the outline shows the moved hem, which hides the lower one, and the crease tells
how far the hidden hem may be from the outline.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import shapely

from tatamu.base.errors import InputError
from tatamu.cameras.edges import Line
from tatamu.cameras.layers import Window, inner_edge, outer_edge
from tatamu.cameras.lens import load_lens
from tatamu.cameras.locate import Located
from tatamu.cameras.photograph import Photograph, find_cloth, load_scale, read_photograph
from tatamu.cameras.pose import Pose
from tatamu.folding.fold import Fold
from tatamu.folding.score import lower_hem
from tatamu.study.result import Result

REACH = 0.06
"""Maximum distance of an edge from its target position [m]."""
LENGTH = 0.12
"""Length of the part of a cloth's edge that is searched, measured from a corner of the cloth [m]."""
CORNERS = ("left", "right", "lower-left", "lower-right")
"""Names of corners that the user can give: two of the moved hem, and two of the opposite, lower hem."""

Measured = dict[str, tuple[float, float]]
"""Value and standard deviation of each measured quantity [m], by name."""


@dataclass(frozen=True)
class FoldReading:
    """The result of reading a finished fold from a photograph."""

    values: Measured
    """Deviations of the fold from its target, by the names of `folding.score.MARKS`."""
    corners: Mapping[str, np.ndarray]
    """Pixels of the corners that were found, shape (2,), by the names of `CORNERS`."""
    outline: np.ndarray
    """Outline of the cloth in the photograph [pixels], shape (n, 2)."""
    targets: Mapping[str, np.ndarray]
    """Pixels at which the corners of the moved hem should be, shape (2,), by the names "left" and "right"."""
    frame: Pose
    """Pose of the fold's frame on the board."""
    photograph: Photograph = field(repr=False)

    def pixels_of(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels of points of the fold's frame [m], shape (n, 3), as shape (n, 2)."""
        placed = np.column_stack([self.frame.place(points[:, :2]), points[:, 2]])
        return self.photograph.view.camera.project(placed)


@dataclass(frozen=True)
class _Corner:
    """A corner of a hem that was found in a photograph, in the fold's frame."""

    place: np.ndarray
    """Position of the corner [m], shape (2,)."""
    deviation: np.ndarray
    """Standard deviations of the position [m], shape (2,): along the direction of the fold, and across it."""
    height: float
    """Height of the corner above the table [m]."""


def read_fold(
    photo: Path | str,
    board: Path | str,
    frame: Located | Pose,
    result: Result,
    *,
    lens: Path | str | None = None,
    corners: Mapping[str, np.ndarray] | None = None,
) -> Measured:
    """Measure in a photograph how a fold ended: the `values` of `view_fold`."""
    return view_fold(photo, board, frame, result, lens=lens, corners=corners).values


def view_fold(
    photo: Path | str,
    board: Path | str,
    frame: Located | Pose,
    result: Result,
    *,
    lens: Path | str | None = None,
    corners: Mapping[str, np.ndarray] | None = None,
) -> FoldReading:
    """Find the hems of a finished fold in a photograph, and measure how they deviate from their targets.

    Args:
        photo: File of a photo that was taken after the fold.
        board: File of the board, or "a4" or "letter"; it must not have moved since `frame` was determined.
        frame: The cloth as it was located before the fold, or the pose of the cloth's frame on the board.
        result: The learned fold that the robot executed.
        lens: File of the camera's lens.
        corners: Pixels of corners by the names of `CORNERS`, shape (2,), which replace those that are found.

    Raises:
        InputError: If a file or a corner's name is wrong, or no corner of the hem is found.
    """
    known = None if lens is None else load_lens(Path(lens))
    photograph = read_photograph(Path(photo), load_scale(board), known)
    pose, spread = (frame, (0.0, 0.0, 0.0)) if isinstance(frame, Pose) else (frame.pose, frame.deviation)
    return FoldReader(photograph, pose, spread, result.task.fold).read({} if corners is None else corners)


class FoldReader:
    """Finds the edges of a finished fold in a photograph."""

    def __init__(self, photograph: Photograph, frame: Pose, spread: tuple[float, float, float], fold: Fold) -> None:
        """Find the outline of the folded cloth; `spread` has the deviations of the frame's x, y [m] and yaw [rad].

        Raises:
            InputError: If the fold uses a single hand, or no cloth is found.
        """
        if fold.hands != 2:
            raise InputError("fold: must use two hands to be measured in a photo; measure this fold with a ruler")
        self._photograph, self._frame, self._spread, self._fold = photograph, frame, spread, fold
        self._hem = {"left": int(fold.left[0]), "right": int(fold.right[0])}  # vertices at the moved hem's corners
        self._edge = find_cloth(photograph).points
        self._axes = np.array([fold.normal, fold.crease.along])
        thickness = fold.garment.material.thickness
        self._rim = 0.3 * thickness  # the rim in the photo is not exactly the edge
        hem = list(self._hem.values())
        self._heights = {"upper": float(fold.target[hem, 2].mean()), "lower": 0.5 * thickness}
        camera = photograph.view.camera
        self._outlines = {
            name: frame.seen_from(camera.on_rim(self._edge, height + 0.5 * thickness))
            for name, height in self._heights.items()
        }
        self._starts = dict(zip(self._hem, fold.start[lower_hem(fold, hem), :2], strict=True))
        self._cloth = shapely.Polygon(self._outlines["upper"]).buffer(0)

    def read(self, given: Mapping[str, np.ndarray]) -> FoldReading:
        """Return what was measured of the fold, with the pixels of given corners by name.

        Raises:
            InputError: If a given corner has an unknown name, or no corner of the hem is found.
        """
        for name in given:
            if name not in CORNERS:
                raise InputError(f"corner: must be one of {', '.join(CORNERS)}, given {name!r}")
        found: dict[str, _Corner] = {}
        for side in self._hem:
            upper, lower = self._corner(side)
            found |= {side: upper} if upper else {}
            found |= {f"lower-{side}": lower} if lower else {}
        self._drop_doubtful(found)
        found |= {name: self._given(name, pixel) for name, pixel in given.items()}
        values = self._values(found)
        if not values:
            raise InputError(
                f"{self._photograph.path}: photo: must show a corner of the moved hem within {1e3 * REACH:.0f} mm of "
                "its target; give the corners' pixels with --corner left=X,Y and --corner right=X,Y, or give --failed "
                "if the fold failed"
            )
        top = self._heights["upper"]
        targets = {side: self._pixel(self._fold.target[vertex, :2], top) for side, vertex in self._hem.items()}
        pixels = {name: self._pixel(corner.place, corner.height) for name, corner in found.items()}
        return FoldReading(values, pixels, self._edge, targets, self._frame, self._photograph)

    def _drop_doubtful(self, found: dict[str, _Corner]) -> None:
        """Drop the moved corners' coordinates across the fold if the hem is so wide that one is of the lower layer."""
        if "left" not in found or "right" not in found:
            return
        left, right = (self._fold.target[vertex, :2] for vertex in self._hem.values())
        seen = float(self._axes[1] @ (found["left"].place - found["right"].place))
        if seen - float(self._axes[1] @ (left - right)) > 0.006:
            for side in self._hem:
                found[side] = replace(found[side], deviation=np.array([found[side].deviation[0], np.inf]))

    def _values(self, found: Mapping[str, _Corner]) -> Measured:
        """Return the deviations of the hems' corners from their targets, along the fold and across the fold."""
        values: Measured = {}
        for side, vertex in self._hem.items():
            if side in found:
                off = self._axes @ (found[side].place - self._fold.target[vertex, :2])
                spread = self._total(found[side])
                for k, axis in enumerate(("along", "across")):
                    if np.isfinite(spread[k]):
                        values[f"{side}_{axis}"] = (float(off[k]), float(spread[k]))
        for k, axis in enumerate(("along", "across")):
            seen = []
            for side in self._hem:
                lower = found.get(f"lower-{side}")
                if lower is not None and np.isfinite(lower.deviation[k]):
                    off = self._axes @ (lower.place - self._starts[side])
                    seen.append((off[k], self._total(lower)[k]))
            if seen:
                offs, spreads = np.array(seen).T
                values[f"slip_{axis}"] = (float(offs.mean()), float(np.sqrt((spreads**2).mean())))
        return values

    def _corner(self, side: str) -> tuple[_Corner | None, _Corner | None]:
        """Return a corner of the moved hem and that of the lower hem below it; None for one that is not found."""
        hem, flank = self._windows(side)
        upper_hem, lower_hem = self._edges(hem)
        upper_flank, lower_flank = self._edges(flank)
        doubt = 0.0 if upper_hem is None or lower_hem is not None else self._unseen(upper_hem, hem)
        upper = None
        if upper_hem and upper_flank and doubt < 0.012:
            upper = self._met(upper_hem, upper_flank, "upper", 0.5 * doubt)
        lower = self._lower(side, lower_hem, lower_flank) if lower_hem or lower_flank else None
        return upper, lower

    def _windows(self, side: str) -> tuple[Window, Window]:
        """Return where the hem and the side edge are expected near a corner of the moved hem."""
        target = self._fold.target
        corner, other = (target[self._hem[each], :2] for each in (side, "right" if side == "left" else "left"))
        width = float(np.linalg.norm(other - corner))
        inwards = (other - corner) / width
        normal, across = self._axes
        out = normal - (normal @ inwards) * inwards
        deep = min(LENGTH, 0.6 * abs(float(self._fold.crease.split(target[[self._hem[side]]])[0][0])))
        sideways = across if side == "left" else -across
        hem = Window(corner, inwards, out / np.linalg.norm(out), min(LENGTH, 0.4 * width), min(REACH, 0.6 * deep))
        return hem, Window(corner, -normal, sideways, deep, min(REACH, 0.45 * width))

    def _edges(self, window: Window) -> tuple[Line | None, Line | None]:
        """Return the edges of the upper and the lower layer in a window; None for one that is not found."""
        top = self._heights["upper"] + self._rim  # inner end of the visible rim
        inner = inner_edge(self._photograph, self._frame, window, top, self._cloth)
        if inner is not None:
            return inner, outer_edge(self._outlines["lower"], window)
        return outer_edge(self._outlines["upper"], window), None

    def _unseen(self, edge: Line, hem: Window) -> float:
        """Return the maximum distance of a hidden hem from the visible hem [m]; infinite if no crease is visible."""
        normal, along = self._axes
        target = self._fold.target
        place = target[int(self._fold.crease.split(target)[0].argmin()), :2] @ normal
        corners = target[list(self._hem.values()), :2]
        half = 0.35 * float(np.linalg.norm(np.diff(corners, axis=0)))
        begin = place * normal + (corners.mean(axis=0) @ along - half) * along
        line = outer_edge(self._outlines["upper"], Window(begin, along, -normal, 2 * half, REACH))
        if line is None:
            return np.inf
        crease = float(line.origin @ normal - place)  # from its target, along the fold
        return abs(2.0 * crease - float((edge.origin - hem.corner) @ normal))

    def _met(self, hem: Line, flank: Line, layer: str, doubt: float = 0.0) -> _Corner:
        place = hem.meets(flank)
        spread = [line.deviation_at(place, max(1.0, line.count / 10.0)) for line in (hem, flank)]
        deviation = np.hypot(np.hypot(spread, [doubt, 0.0]), self._rim)
        return _Corner(place, deviation, self._heights[layer])

    def _lower(self, side: str, hem: Line | None, flank: Line | None) -> _Corner:
        """Return a corner of the lower hem; if one edge is not seen, the deviation along the other is infinite."""
        if hem is not None and flank is not None:
            return self._met(hem, flank, "lower")
        seen, k = (hem, 0) if hem is not None else (flank, 1)
        assert seen is not None
        foot = Line(self._starts[side], self._axes[k], 0.0, 1.0, 1).meets(seen)
        deviation = np.full(2, np.inf)
        deviation[k] = np.hypot(seen.deviation_at(foot, max(1.0, seen.count / 10.0)), self._rim)
        return _Corner(foot, deviation, self._heights["lower"])

    def _given(self, name: str, pixel: np.ndarray) -> _Corner:
        height = self._heights["lower" if name.startswith("lower") else "upper"]
        on_table = self._photograph.view.camera.on_table(np.asarray(pixel, dtype=float)[None], height)
        place = self._frame.seen_from(on_table)[0]
        size = 1.5 * self._photograph.resolution(self._frame.place(place[None]))
        return _Corner(place, np.full(2, np.hypot(size, self._rim)), height)

    def _total(self, corner: _Corner) -> np.ndarray:
        """Return a corner's deviations along and across the fold, with those of camera and frame, shape (2,)."""
        pixel = self._pixel(corner.place, corner.height)[None]
        camera = float(self._photograph.view.deviation(pixel, corner.height)[0]) / np.sqrt(2.0)
        x, y, yaw = self._spread
        lever = np.abs(self._axes @ np.array([-corner.place[1], corner.place[0]])) * yaw
        frame = np.hypot(max(x, y), lever)
        return np.sqrt(corner.deviation**2 + camera**2 + frame**2)

    def _pixel(self, place: np.ndarray, height: float) -> np.ndarray:
        return self._photograph.in_pixels(self._frame.place(place[None]), height)[0]
