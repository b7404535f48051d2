"""Finds the pose, the size and the outline of a garment on the table in a photograph."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from tatamu.base.errors import InputError
from tatamu.cameras.lens import load_lens
from tatamu.cameras.photograph import Photograph, find_cloth, load_scale, read_photograph, without_lens
from tatamu.cameras.pose import Pose, touched_pose, wrapped
from tatamu.cameras.shape import Fit, Shape, again, lay, shape_of
from tatamu.garments import make_garment
from tatamu.study.result import Result


@dataclass(frozen=True)
class Located:
    """A garment that was found on the table in a photograph."""

    garment: str
    pose: Pose
    """Pose of the garment's frame in the board's frame."""
    place: Pose | None
    """Pose of the garment's frame in the robot's base frame, if the board's pose there is known."""
    deviation: tuple[float, float, float]
    """Standard deviations of x, y [m] and yaw [rad] of the garment's pose."""
    size: tuple[float, float]
    """Width and length of the garment in the photograph [m]."""
    size_deviation: tuple[float, float]
    """Standard deviations of the garment's width and length [m]."""
    area: float
    """Area inside the garment's outline [m2]."""
    outline: np.ndarray
    """Points of the outline [m], shape (n, 2), in the robot's base frame if `place` is known, otherwise in the
    board's."""
    corners: Mapping[str, np.ndarray]
    """Corners of the fitted outline by name, in the frame of `outline` [m], shape (2,)."""
    rms: float
    """Root mean square distance between the found and the fitted outline [m]."""
    learned: bool
    """Whether the cloth is compared with the size of the garment, because this was learned or given."""
    fit: Fit = field(repr=False)
    photograph: Photograph = field(repr=False)
    edge: np.ndarray = field(repr=False)
    """Outline in the photograph [pixels], shape (n, 2)."""
    notes: tuple[str, ...] = ()
    """Notes for the user on files that probably do not belong to the photograph."""

    def describe(self) -> dict[str, Any]:
        """Return the contents of the JSON file."""
        place = self.place
        shape = self.fit.shape
        learned = {"size": shape.size[::-1].tolist(), "area": float(shape.polygon.area)} if self.learned else None
        return {
            "version": 1,
            "garment": self.garment,
            "frame": "board" if place is None else "base",
            "pose_on_board": asdict(self.pose),
            "place": None if place is None else asdict(place),
            "deviation": dict(zip(("x", "y", "yaw"), self.deviation, strict=True)),
            "size": list(self.size),
            "size_deviation": list(self.size_deviation),
            "area": self.area,
            "corners": {name: point.tolist() for name, point in self.corners.items()},
            "outline": self.outline.round(5).tolist(),
            "outline_rms": self.rms,
            "learned": learned,
        }

    def comparison(self) -> list[str]:
        """Return the differences between the garment and the size that was learned or given, as lines of text."""
        shape = self.fit.shape
        width, length = (now / then - 1 for now, then in zip(self.size, shape.size[::-1].tolist(), strict=True))
        share = self.area / float(shape.polygon.area) - 1
        sides = f"width {100 * width:+.1f} %, length {100 * length:+.1f} %"
        found = [f"compared with {shape.size[1]:.3f} x {shape.size[0]:.3f} m: {sides}, area {100 * share:+.1f} %"]
        if share < -0.03:
            found.append("note: the area is too small; smooth out wrinkles, or learn the fold for this size")
        elif max(abs(width), abs(length)) > 0.02:
            found.append("note: the garment differs in size from the learned fold; learn the fold for this size")
        return found

    def lines(self) -> list[str]:
        """Return the pose and size of the garment, with notes for the user, as lines of text."""
        x, y, yaw = self.deviation
        width, length = self.size
        lens = "" if self.photograph.view.lens is not None else " or --lens"
        pose = self.place or self.pose
        frame = "board's frame" if self.place is None else "robot's base frame"
        found = [
            f"{self.garment}: {width:.3f} x {length:.3f} m, area {self.area:.4f} m2; "
            f"its outline deviates by {1e3 * self.rms:.1f} mm",
            f"pose in the {frame}: x {pose.x:.4f} m (+- {1e3 * x:.1f} mm), y {pose.y:.4f} m (+- {1e3 * y:.1f} mm), "
            f"yaw {np.degrees(pose.yaw):.2f} deg (+- {np.degrees(yaw):.2f} deg)",
            *(self.comparison() if self.learned else []),
            *self.notes,
        ]
        if max(x, y) > 0.003:
            known = f"the pose is known only to within {1e3 * max(x, y):.0f} mm"
            found.append(f"note: {known}; lay the board closer, or use a second page{lens}")
        if self.place is None:
            found.append("note: give --board-pose or --touch to get the --place for `tatamu plan`")
        else:
            found.append(f"--place {self.place}")
        return found


def locate(
    photo: Path | str,
    board: Path | str,
    *,
    run: Result | Path | str | None = None,
    garment: str = "towel",
    size: tuple[float, float] | None = None,
    board_pose: Pose | tuple[float, float, float] | None = None,
    touched: np.ndarray | None = None,
    lens: Path | str | None = None,
    corners: Mapping[str, np.ndarray] | None = None,
    join: bool = False,
) -> Located:
    """Find a garment on the table in a photo. The command `tatamu locate` does the same.

    Args:
        photo: File of the photo, which shows all of the cloth and, next to it, the board.
        board: File of the board, or "a4" or "letter" for a plain white sheet.
        run: Learned fold, or its folder, with whose garment the cloth is compared.
        garment: Name or file of the garment with which the cloth is compared if there is no `run`.
        size: Width and length with which the cloth is compared [m]; None to accept any size.
        board_pose: Pose of the board in the robot's base frame [m, m, rad].
        touched: Positions of the marks A, B and C that the robot touched, in its base frame [m], shape (3, 2) or (3,
            3).
        lens: File of the camera's lens.
        corners: Pixels of corners by name, shape (2,), which replace those that are found.
        join: Whether all regions that differ from the table belong to the cloth.

    Raises:
        InputError: If an argument or a file is wrong, the garment is not found, or one of its corners is turned in.
    """
    if board_pose is not None and touched is not None:
        raise InputError("board-pose, touch: must not both be given; leave one out")
    scale = load_scale(board)
    pose = None if board_pose is None else board_pose if isinstance(board_pose, Pose) else Pose(*board_pose)
    if touched is not None:
        pose = touched_pose(scale.marks, np.asarray(touched, dtype=float))
    if run is None:
        shape = shape_of(make_garment(garment, size=size))
    else:
        result = run if isinstance(run, Result) else Result.load(run)
        shape = shape_of(result.task.fold.garment, result.start)  # as it lies before the fold
    photograph = read_photograph(Path(photo), scale, None if lens is None else load_lens(Path(lens)))
    learned = run is not None or size is not None
    return locate_shape(photograph, shape, board_pose=pose, learned=learned, given=corners, join=join)


def locate_shape(
    photograph: Photograph,
    shape: Shape,
    *,
    board_pose: Pose | None = None,
    learned: bool = False,
    given: Mapping[str, np.ndarray] | None = None,
    join: bool = False,
) -> Located:
    """Find a garment with a given outline on the table; `locate` explains the arguments.

    If `learned` is true, the cloth must have the size of `shape`.

    Raises:
        InputError: If the garment is not found, or one of its corners is turned in.
    """
    camera = photograph.view.camera
    edge = find_cloth(photograph, join).points
    pinned = given or {}
    for name in pinned:
        if name not in shape.corners:
            raise InputError(f"corner: must be one of {', '.join(shape.corners)}, given {name!r}")
    shown = {name: camera.on_table(pixel[None], shape.height)[0] for name, pixel in pinned.items()}
    found = camera.on_rim(edge, 2.0 * shape.height)
    fit = lay(shape, found, shown, board_pose)
    _check(photograph.path, fit, found, pinned, learned)
    doubt = _lens_doubt(photograph, fit, edge) if learned and photograph.view.lens is not None else ()
    covariance = fit.covariance + _of_camera(photograph, fit, edge, pinned)
    spread = np.sqrt(np.diag(covariance))
    length, width = (shape.size * fit.scale).tolist()
    outer = board_pose or Pose()
    plane = outer.rotation @ covariance[:2, :2] @ outer.rotation.T
    x, y, yaw = np.sqrt([plane[0, 0], plane[1, 1], covariance[2, 2]]).tolist()
    return Located(
        shape.name,
        fit.pose,
        None if board_pose is None else fit.pose.within(board_pose),
        (x, y, yaw),
        (width, length),
        (float(width * spread[4]), float(length * spread[3])),
        float(shapely.Polygon(found).area),
        outer.place(found),
        {name: outer.place(fit.place(corner[None]))[0] for name, corner in shape.corners.items()},
        fit.rms,
        learned,
        fit,
        photograph,
        edge,
        doubt,
    )


def _of_camera(photograph: Photograph, fit: Fit, edge: np.ndarray, given: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the covariance of a fit's parameters due to the uncertainty of the camera, shape (5, 5)."""
    total = np.zeros((5, 5))
    height = fit.shape.height
    for camera in photograph.view.varied():
        corners = {name: camera.on_table(pixel[None], height)[0] for name, pixel in given.items()}
        moved = again(fit.shape, camera.on_rim(edge, 2.0 * height), corners, fit.parameters).parameters - fit.parameters
        moved[2] = wrapped(float(moved[2]))
        total += np.outer(moved, moved)
    return total


def _lens_doubt(photograph: Photograph, fit: Fit, edge: np.ndarray) -> tuple[str, ...]:
    """Return a note if the size of the cloth fits much better without the lens file."""
    off = float(np.abs(fit.parameters[3:]).max())
    if off < 0.015:
        return ()
    try:
        found = without_lens(photograph).view.camera.on_rim(edge, 2.0 * fit.shape.height)
    except InputError:
        return ()
    free = float(np.abs(again(fit.shape, found, {}, fit.parameters).parameters[3:]).max())
    if free > 0.5 * off:
        return ()
    return (
        f"note: the size is off by {100 * off:.1f} % with this lens, and by {100 * free:.1f} % without; does the lens "
        "file belong to this camera and zoom?",
    )


def _check(path: Path, fit: Fit, found: np.ndarray, shown: Collection[str], learned: bool) -> None:
    """Refuse an outline that does not fit the garment, or with a corner that is turned in, or of another size.

    If the size differs much, part of the cloth was probably taken for table.
    """
    ring = shapely.LinearRing(found)
    gaps = {name: ring.distance(shapely.Point(fit.place(place[None])[0])) for name, place in fit.shape.corners.items()}
    turned = {name: gap for name, gap in gaps.items() if gap > 0.015 and name not in shown}
    if fit.rms > 0.010 or len(turned) > 2:  # another garment, or wrinkles
        raise InputError(
            f"{path}: the cloth must look like a flat {fit.shape.name}, but the outline deviates by "
            f"{1e3 * fit.rms:.0f} mm and misses {len(turned)} of {len(gaps)} corners; lay the cloth flat, or give "
            "another --garment"
        )
    if turned:
        name = max(turned, key=lambda each: turned[each])
        raise InputError(
            f"{path}: corner {name} must lie flat, but is turned in by {1e3 * turned[name]:.0f} mm; lay the corner "
            f"flat, or give its pixel with --corner {name}=X,Y"
        )
    if learned and not (np.abs(np.log(fit.scale)) < 0.15).all():
        length, width = fit.shape.size * fit.scale
        size = f"{fit.shape.size[1]:.3f} x {fit.shape.size[0]:.3f} m"
        raise InputError(
            f"{path}: the cloth must measure {size}, but measures {width:.3f} x {length:.3f} m in the photo; check "
            "--size and `bar` in the board's file, or use a table of another colour"
        )
