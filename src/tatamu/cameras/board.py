"""Defines the printed board that lies next to the cloth and gives a photograph its scale.

Each page is a ChArUco pattern: a chessboard with a coded marker in every white square (Garrido-Jurado et al. 2014). Its
corners are numbered, so a few visible ones suffice. The first page gives the board's frame: the origin is mark A, the
lower left corner of the pattern, x points to mark B and y to mark C. Further pages may lie anywhere on the table.

The board is written as a PDF file that prints at its true size; every line lies on whole dots.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w
from PIL import Image, ImageDraw, ImageFont
from pydantic import Field

from tatamu.base.files import read_record, replacing, write_text
from tatamu.base.records import Record
from tatamu.cameras import opencv

PAPERS = {"a4": (0.210, 0.297), "letter": (0.2159, 0.2794)}
"""Width and height of each paper size [m] (ISO 216, ANSI/ASME Y14.1)."""
COLUMNS, ROWS = 6, 8
"""Numbers of squares of the board's chessboard, across and along the page."""
SQUARE = 0.030
"""Intended side length of a square [m]."""
BAR = 0.150
"""Intended length of the scale bar that is printed on the board [m]."""
TOP = 0.012
"""Distance between the board's chessboard and the upper edge of the paper [m]."""
MARKERS = COLUMNS * ROWS // 2
Paper = Literal["a4", "letter"]
HEAD = """\
# The board printed from {pdf}.
# Measure the scale bar under the pattern with a ruler, and correct `bar` [m] if the printer changed its length.

"""
DOTS = 20_000
"""Number of dots per metre of a printed page."""


class Board(Record):
    """The description of a printed board, which gives a photograph its scale."""

    paper: Paper = "a4"
    bar: float = Field(BAR, gt=0.5 * BAR, lt=2.0 * BAR)
    """Measured length of the scale bar that is printed on the board [m]."""
    pages: int = Field(1, ge=1, le=8)

    @property
    def scale(self) -> float:
        """Ratio of the board's printed size to its intended size."""
        return self.bar / BAR

    @property
    def size(self) -> np.ndarray:
        """Width and height of the board's chessboard as printed [m], shape (2,)."""
        return self.scale * SQUARE * np.array([COLUMNS, ROWS])

    @property
    def marks(self) -> np.ndarray:
        """Positions of the marks A, B and C at corners of the pattern, in the board's frame [m], shape (3, 2)."""
        width, height = self.size
        return np.array([[0.0, 0.0], [width, 0.0], [0.0, height]])

    @property
    def rim(self) -> np.ndarray:
        """Corners of the paper of a page, in the frame of this page [m], in counter-clockwise order, shape (4, 2)."""
        wide, tall = PAPERS[self.paper]
        left = 0.5 * (wide - SQUARE * COLUMNS)
        low = -(tall - TOP - SQUARE * ROWS)
        corners = np.array([[-left, low], [wide - left, low], [wide - left, low + tall], [-left, low + tall]])
        return self.scale * corners

    @property
    def corners(self) -> np.ndarray:
        """Inner corners of a chessboard in the frame of its page, in OpenCV's order [m], shape (35, 2)."""
        across, down = np.meshgrid(np.arange(1, COLUMNS), np.arange(1, ROWS))
        places = np.column_stack([across.ravel(), ROWS - down.ravel()])
        return self.scale * SQUARE * places

    def pattern(self, page: int) -> Any:
        """Return OpenCV's description of a page of the board; the first page has number 0."""
        aruco = opencv().aruco
        dictionary = aruco.getPredefinedDictionary(aruco.DICT_4X4_250)
        ids = MARKERS * page + np.arange(MARKERS)
        return aruco.CharucoBoard((COLUMNS, ROWS), SQUARE, 0.024, dictionary, ids)  # with the side of a marker [m]


def load_board(path: Path) -> Board:
    """Read a board from its file."""
    return read_record(Board, "board", path)


def write_board(board: Board, path: Path, pdf: Path) -> None:
    """Write the file that describes a board, which is printed from the file `pdf`."""
    write_text(path, HEAD.format(pdf=pdf.name) + tomli_w.dumps({"board": board.model_dump()}))


def page(board: Board, number: int) -> Image.Image:
    """Return a page of the board as a grey picture with 20 dots per millimetre. The first page has number 0."""
    wide, tall = (round(side * DOTS) for side in PAPERS[board.paper])
    sheet = Image.new("L", (wide, tall), 255)
    size = (round(COLUMNS * SQUARE * DOTS), round(ROWS * SQUARE * DOTS))
    left, top = (wide - size[0]) // 2, round(TOP * DOTS)
    sheet.paste(Image.fromarray(board.pattern(number).generateImage(size)), (left, top))
    canvas = ImageDraw.Draw(sheet)
    bottom, right = top + size[1], left + size[0]
    font: Any = ImageFont.load_default(0.0038 * DOTS)
    long, line = round(0.005 * DOTS), round(0.0003 * DOTS)
    for x, y, name in ((left, bottom, "A"), (right, bottom, "B"), (left, top, "C")):
        ahead, down = (long if x == right else -long), (long if y == bottom else -long)
        canvas.line([(x, y), (x + ahead, y)], 0, line)
        canvas.line([(x, y), (x, y + down)], 0, line)
        place = (x + 0.7 * ahead, y + 0.8 * down)
        canvas.text(place, name if number == 0 else "", 0, font, anchor="mm")
    start, y, bar = (wide - round(BAR * DOTS)) // 2, bottom + round(0.009 * DOTS), round(BAR * DOTS)
    canvas.line([(start, y), (start + bar, y)], 0, line)
    for tick in np.arange(0.0, BAR + 1e-9, 0.01):  # every centimetre
        high = round((0.004 if tick in (0.0, BAR) else 0.002) * DOTS)
        x = start + round(tick * DOTS)
        canvas.line([(x, y - high), (x, y)], 0, line)
    canvas.text((start + bar // 2, y + round(0.0015 * DOTS)), f"{1e3 * BAR:.0f} mm", 0, font, anchor="mt")
    text = (
        f"tatamu board, page {number + 1} of {board.pages}: {1e3 * SQUARE:.0f} mm squares, "
        f"markers {MARKERS * number} to {MARKERS * (number + 1) - 1}. Print at 100 %, lay it flat."
    )
    canvas.text((wide // 2, bottom + round(0.017 * DOTS)), text, 0, font, anchor="mt")
    return sheet


def write_pdf(board: Board, path: Path) -> None:
    """Write all pages of a board as a PDF file at their true size."""
    first, *others = (page(board, number).convert("1") for number in range(board.pages))
    with replacing(path) as temporary:
        # without dates, the same board always makes the same file
        dated: dict[str, Any] = {"creationDate": None, "modDate": None, "title": "tatamu board"}
        first.save(temporary, "PDF", resolution=DOTS * 0.0254, save_all=True, append_images=others, **dated)
