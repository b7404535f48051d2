"""The printed board that gives a photograph its scale: a ChArUco pattern of known size next to the cloth.

A ChArUco pattern (Garrido-Jurado et al. 2014) is a chessboard with a coded marker in every white square. Its corners
are found to a fraction of a pixel, and each is known by its number even if others are covered.

The board's frame: the mark A at the lower left corner of the pattern is the origin, x points to mark B on its right, y
to mark C above it, z out of the paper. A board may have several pages, each with other markers. The frame is that of
the first page; the others may lie anywhere flat on the table.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w
from pydantic import Field

from tatamu.errors import InputError
from tatamu.files import read_toml, validated, write_text
from tatamu.photographs.opencv import opencv
from tatamu.records import Record

PAPERS = {"a4": (0.210, 0.297), "letter": (0.2159, 0.2794)}
"""Width and height of sheets [m]: ISO 216, ANSI/ASME Y14.1."""
COLUMNS, ROWS = 6, 8
"""Squares of the pattern, across and along the page."""
SQUARE = 0.030
"""Side of a square as it is meant to be printed [m]."""
MARKER = 0.024
"""Side of a marker as it is meant to be printed [m]."""
BAR = 0.150
"""Length of the scale bar as it is meant to be printed [m]."""
TOP = 0.012
"""Space above the pattern [m]."""
MARKERS = COLUMNS * ROWS // 2
"""Markers of a page."""
Paper = Literal["a4", "letter"]

HEAD = """\
# The board printed from {pdf}.
# Measure the scale bar under the pattern with a ruler, and correct `bar` [m] if the printer changed its length.

"""


class Board(Record):
    """The description of a printed board."""

    paper: Paper = "a4"
    bar: float = Field(BAR, gt=0.5 * BAR, lt=2.0 * BAR)
    """Measured length of the scale bar [m]."""
    pages: int = Field(1, ge=1, le=8)

    @property
    def scale(self) -> float:
        """Printed size over meant size."""
        return self.bar / BAR

    @property
    def size(self) -> np.ndarray:
        """Width and height of the pattern as printed [m], shape (2,)."""
        return self.scale * SQUARE * np.array([COLUMNS, ROWS])

    @property
    def marks(self) -> np.ndarray:
        """Marks A, B and C in the board's frame [m], shape (3, 2)."""
        width, height = self.size
        return np.array([[0.0, 0.0], [width, 0.0], [0.0, height]])

    @property
    def rim(self) -> np.ndarray:
        """Corners of the paper in the frame of its page [m], counter-clockwise, shape (4, 2)."""
        wide, tall = PAPERS[self.paper]
        left = 0.5 * (wide - SQUARE * COLUMNS)
        low = -(tall - TOP - SQUARE * ROWS)
        corners = np.array([[-left, low], [wide - left, low], [wide - left, low + tall], [-left, low + tall]])
        return self.scale * corners

    @property
    def corners(self) -> np.ndarray:
        """Inner corners of the pattern in the frame of its page [m], in OpenCV's order, shape (35, 2)."""
        across, down = np.meshgrid(np.arange(1, COLUMNS), np.arange(1, ROWS))
        places = np.column_stack([across.ravel(), ROWS - down.ravel()])
        return self.scale * SQUARE * places

    def pattern(self, page: int) -> Any:
        """Return OpenCV's description of a page, the first being 0."""
        aruco = opencv().aruco
        dictionary = aruco.getPredefinedDictionary(aruco.DICT_4X4_250)
        ids = MARKERS * page + np.arange(MARKERS)
        return aruco.CharucoBoard((COLUMNS, ROWS), SQUARE, MARKER, dictionary, ids)


def load_board(path: Path) -> Board:
    """Read the file of a board.

    Raises:
        InputError: If the file cannot be read, or a field is wrong.
    """
    value = read_toml(path)
    if list(value) != ["board"]:
        raise InputError(f"{path}: must have one table [board], given {', '.join(map(str, value)) or 'none'}")
    return validated(Board, value["board"], path)


def write_board(board: Board, path: Path, pdf: Path) -> None:
    """Write the file of a board that is printed from a PDF file."""
    write_text(path, HEAD.format(pdf=pdf.name) + tomli_w.dumps({"board": board.model_dump()}))
