"""A board found in a photograph: the corners of each of its pages."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.errors import InputError
from tatamu.photographs.board import MARKERS, Board
from tatamu.photographs.camera import Seen
from tatamu.photographs.opencv import opencv

FEWEST = 8
"""Corners of a page that place it."""
BLURRED = 9.0
"""Width of the sharpest edges of a blurred photograph, in thousandths of its longer side."""


@dataclass(frozen=True)
class FoundPage:
    """A page of a board in a photograph."""

    number: int
    """The first page is 0."""
    corners: Seen


def find_pages(grey: np.ndarray, board: Board) -> list[FoundPage]:
    """Find the pages of a board, the first page first; further pages count even if the board's file has fewer.

    Args:
        grey: The photograph, uint8, shape (h, w).
        board: The board.

    Raises:
        InputError: If the first page is not seen, or too little of it.
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
        if count >= FEWEST:
            pages.append(FoundPage(number, (board.corners[corners.ravel()], np.asarray(pixels, float).reshape(-1, 2))))
        elif number == 0:
            raise InputError(
                f"board: only {count} of {len(board.corners)} corners of its first page are seen, at least {FEWEST} "
                "are needed: show all of it, sharp and without glare"
            )
    return pages


def _check(seen: np.ndarray, grey: np.ndarray) -> None:
    """Refuse a photo without markers of the board's first page."""
    if (seen < MARKERS).any():
        return
    if len(seen):
        raise InputError(
            f"board: the photo shows markers {seen.min()} to {seen.max()}, which are not those of the first page "
            f"(0 to {MARKERS - 1}): lay the page that tatamu printed for this board file beside the cloth"
        )
    other = _other_dictionary(grey)
    if other:
        raise InputError(f"board: the photo shows markers of another board ({other}); print one with `tatamu board`")
    if edge_width(grey) > BLURRED:
        raise InputError("photo: is blurred, so that no board is found: hold the camera still and focus on the board")
    raise InputError("board: is not seen in the photo: show all of it beside the cloth, in even light, or give --sheet")


def _other_dictionary(grey: np.ndarray) -> str:
    """Return the name of a usual dictionary of which several markers are seen; empty if there is none."""
    aruco = opencv().aruco
    for name in ("DICT_5X5_250", "DICT_6X6_250", "DICT_APRILTAG_36h11"):
        dictionary = aruco.getPredefinedDictionary(getattr(aruco, name))
        _, ids, _ = aruco.ArucoDetector(dictionary, aruco.DetectorParameters()).detectMarkers(grey)
        if ids is not None and len(ids) >= 3:
            return name
    return ""


def edge_width(grey: np.ndarray) -> float:
    """Return how wide the sharpest edges of a photograph are, in thousandths of its longer side."""
    smooth = opencv().GaussianBlur(grey, (0, 0), 1.0).astype(float)
    steepest = np.percentile(np.hypot(*np.gradient(smooth)), 99.9)
    low, high = np.percentile(smooth, [1.0, 99.0])
    return float(1e3 * (high - low) / max(steepest, 1e-9) / max(grey.shape))
