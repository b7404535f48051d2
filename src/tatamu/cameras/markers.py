"""Finds a printed board in a photograph: the corners of the chessboards on all visible pages."""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.cameras import opencv
from tatamu.cameras.board import MARKERS, Board
from tatamu.cameras.camera import Seen

MIN_CORNERS = 8
"""Minimum number of corners that give the pose of a page."""


def find_pages(grey: np.ndarray, board: Board) -> list[Seen]:
    """Find the corners on each page of a board in a grey photograph, uint8, shape (h, w); the first page comes first.

    Further pages are found even if the board's file states fewer pages.

    Raises:
        InputError: If too little of the first page is visible.
    """
    aruco = opencv().aruco
    dictionary = board.pattern(0).getDictionary()
    quads, ids, _ = aruco.ArucoDetector(dictionary, aruco.DetectorParameters()).detectMarkers(grey)
    seen = np.empty(0, dtype=int) if ids is None else ids.ravel()
    _check(seen, grey)
    pages = []
    for number in np.unique(seen // MARKERS).tolist():
        own = np.flatnonzero(seen // MARKERS == number)
        detector = aruco.CharucoDetector(board.pattern(number))
        pixels, corners, _, _ = detector.detectBoard(
            grey, markerCorners=[quads[k] for k in own], markerIds=seen[own][:, None]
        )
        count = 0 if corners is None else len(corners)
        if count >= MIN_CORNERS:
            pages.append(_refined(grey, board.corners[corners.ravel()], np.asarray(pixels, float)))
        elif number == 0:
            raise InputError(
                f"board: the photo must show at least {MIN_CORNERS} of the {len(board.corners)} corners of the first "
                f"page, given {count}; show the whole page, sharp and without glare"
            )
    return pages


def _refined(grey: np.ndarray, places: np.ndarray, pixels: np.ndarray) -> Seen:
    """Return a chessboard's corners on the page and their refined pixels, without those that move too far."""
    first = pixels.reshape(-1, 2)
    found = saddles(grey, first)
    kept = np.linalg.norm(found - first, axis=1) < 2.0
    return (places[kept], found[kept]) if kept.sum() >= MIN_CORNERS else (places, first)


def saddles(grey: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the positions of a chessboard's corners with an error of a few hundredths of a pixel, shape (n, 2).

    A quadratic function is fitted to the brightness around each corner of a grey photograph, uint8, and its saddle
    point is the corner (Lucchese and Mitra 2002, Asia-Pacific Conference on Circuits and Systems). The given `corners`
    are right to about a pixel. OpenCV's own refinement is disturbed by the markers' edges and errs by a quarter of a
    pixel.
    """
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    # the window must not reach the markers inside the squares
    reach = int(np.clip(np.round(0.13 * np.median(apart.min(axis=0))), 2, 10))
    side = np.arange(-reach, reach + 1.0)
    x, y = (each.ravel() for each in np.meshgrid(side, side))
    terms = np.column_stack([x**2, x * y, y**2, x, y, np.ones_like(x)])
    weighted = terms.T * np.exp(-2.0 * (x**2 + y**2) / reach**2)
    solve = np.linalg.solve(weighted @ terms, weighted)
    found = corners.copy()
    for _ in range(8):  # the window follows the corner
        places = (found[:, None] + np.column_stack([x, y])).astype(np.float32)
        bright = opencv().remap(grey.astype(np.float32), places[..., 0], places[..., 1], opencv().INTER_CUBIC)
        a, b, c, d, e, _ = solve @ bright.T
        bend = np.minimum(4.0 * a * c - b * b, -1e-9)  # negative at a saddle
        found += np.clip(np.column_stack([b * e - 2.0 * c * d, b * d - 2.0 * a * e]) / bend[:, None], -1.0, 1.0)
    return found


def _check(seen: np.ndarray, grey: np.ndarray) -> None:
    """Refuse a photo that shows no marker of the board's first page."""
    if (seen < MARKERS).any():
        return
    if len(seen):
        raise InputError(
            f"board: the photo must show the first page (markers 0 to {MARKERS - 1}), given markers {seen.min()} to "
            f"{seen.max()}; lay the first page beside the cloth"
        )
    other = _other_dictionary(grey)
    if other:
        raise InputError(
            f"board: must come from `tatamu board`, given a board with markers {other}; print a board with this command"
        )
    if edge_width(grey) > 9.0:
        raise InputError("photo: is too blurred to find a board; hold the camera still and focus on the board")
    raise InputError(
        "board: must be visible in the photo; show the whole board beside the cloth in even light, or give --sheet"
    )


def _other_dictionary(grey: np.ndarray) -> str:
    """Return the name of another set of markers that the photo shows; empty if there is none."""
    aruco = opencv().aruco
    for name in ("DICT_5X5_250", "DICT_6X6_250", "DICT_APRILTAG_36h11"):
        dictionary = aruco.getPredefinedDictionary(getattr(aruco, name))
        _, ids, _ = aruco.ArucoDetector(dictionary, aruco.DetectorParameters()).detectMarkers(grey)
        if ids is not None and len(ids) >= 3:
            return name
    return ""


def edge_width(grey: np.ndarray) -> float:
    """Return the width of the sharpest edges of a photograph, in thousandths of the photograph's longer side."""
    smooth = opencv().GaussianBlur(grey, (0, 0), 1.0).astype(float)
    steepest = np.percentile(np.hypot(*np.gradient(smooth)), 99.9)
    low, high = np.percentile(smooth, [1.0, 99.0])
    return float(1e3 * (high - low) / max(steepest, 1e-9) / max(grey.shape))
