"""Finds the pose, the size and the outline of a garment on the table in a photograph."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import shapely

from tatamu.base.errors import InputError
from tatamu.cameras.fit import Fit, again, lay
from tatamu.cameras.lens import load_lens
from tatamu.cameras.located import Comparison, Located
from tatamu.cameras.mounting import touched_pose
from tatamu.cameras.photograph import Photograph, find_cloth, load_scale, read_photograph, without_lens
from tatamu.cameras.pose import Pose, wrapped
from tatamu.cameras.shape import Shape, shape_of
from tatamu.garments import make_garment
from tatamu.study.result import Result


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
        raise InputError("board-pose, touch: at most one must be given, given both")
    scale = load_scale(board)
    pose = None if board_pose is None else board_pose if isinstance(board_pose, Pose) else Pose(*board_pose)
    if touched is not None:
        pose = touched_pose(scale.marks, np.asarray(touched, dtype=float))
    shape = shape_of(make_garment(garment, size=size)) if run is None else learned_shape(run)
    photograph = read_photograph(Path(photo), scale, None if lens is None else load_lens(Path(lens)))
    return locate_shape(
        photograph,
        shape,
        board_pose=pose,
        learned=run is not None or size is not None,
        given=corners,
        join=join,
    )


def learned_shape(run: Result | Path | str) -> Shape:
    """Return the shape of the garment of a learned fold, as it lies before the fold."""
    result = run if isinstance(run, Result) else Result.load(run)
    return shape_of(result.task.fold.garment, result.start)


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
    path = photograph.path
    camera = photograph.view.camera
    edge = find_cloth(photograph, join).points
    pinned = {} if given is None else dict(given)
    for name in pinned:
        if name not in shape.corners:
            raise InputError(f"corner: must be one of {', '.join(shape.corners)}, given {name!r}")
    shown = {name: camera.on_table(pixel[None], shape.height)[0] for name, pixel in pinned.items()}
    found = camera.on_rim(edge, 2.0 * shape.height)
    fit = lay(shape, found, shown, board_pose)
    _check(path, fit, found, set(pinned))
    if learned:
        _check_size(path, fit)
    doubt = _lens_doubt(photograph, fit, edge) if learned and photograph.view.lens is not None else ()
    covariance = fit.covariance + _of_camera(photograph, fit, edge, pinned)
    spread = np.sqrt(np.diag(covariance))
    length, width = (shape.size * fit.scale).tolist()
    outer = board_pose or Pose()
    area = float(shapely.Polygon(found).area)
    return Located(
        shape.name,
        fit.pose,
        None if board_pose is None else fit.pose.within(board_pose),
        _turned(covariance, outer),
        (width, length),
        (float(width * spread[4]), float(length * spread[3])),
        area,
        outer.place(found),
        {name: outer.place(fit.place(corner[None]))[0] for name, corner in shape.corners.items()},
        fit.rms,
        Comparison((float(shape.size[1]), float(shape.size[0])), float(shape.polygon.area)) if learned else None,
        fit,
        photograph,
        edge,
        doubt,
    )


def _turned(covariance: np.ndarray, outer: Pose) -> tuple[float, float, float]:
    """Return the deviations of x, y and yaw in an outer frame, in which the covariance's frame has the pose `outer`."""
    plane = outer.rotation @ covariance[:2, :2] @ outer.rotation.T
    x, y, yaw = np.sqrt([plane[0, 0], plane[1, 1], covariance[2, 2]]).tolist()
    return x, y, yaw


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
        f"note: the size is off by {100 * off:.1f} % with this lens, and by {100 * free:.1f} % without; is the lens "
        "file of this camera and zoom?",
    )


def _check_size(path: object, fit: Fit) -> None:
    """Refuse cloth whose size differs much from the expected size, because part of it was probably taken for table."""
    if not (np.abs(np.log(fit.scale)) < 0.15).all():
        length, width = fit.shape.size * fit.scale
        size = f"{fit.shape.size[1]:.3f} x {fit.shape.size[0]:.3f} m"
        raise InputError(
            f"{path}: the outline has {width:.3f} x {length:.3f} m, but the cloth {size}; lay the cloth flat on a "
            "table of another colour, or check --size and the board's `bar`"
        )


def _check(path: object, fit: Fit, found: np.ndarray, shown: set[str]) -> None:
    """Refuse an outline that does not fit the garment, and an outline with a corner that is turned in."""
    ring = shapely.LinearRing(found)
    gaps = {name: ring.distance(shapely.Point(fit.place(place[None])[0])) for name, place in fit.shape.corners.items()}
    turned = {name: gap for name, gap in gaps.items() if gap > 0.015 and name not in shown}
    if fit.rms > 0.010 or len(turned) > 2:  # another garment, or wrinkles
        raise InputError(
            f"{path}: the outline must be that of a flat {fit.shape.name}, but deviates by {1e3 * fit.rms:.0f} mm and "
            f"lacks {len(turned)} corners; lay the cloth flat, or give another --garment"
        )
    if turned:
        name = max(turned, key=lambda each: turned[each])
        raise InputError(
            f"{path}: the corner {name} is turned in by {1e3 * turned[name]:.0f} mm; lay the corner flat, or show its "
            f"place with --corner {name}=X,Y"
        )
