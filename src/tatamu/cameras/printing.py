"""Writes the board as a PDF file that prints at its true size; every line lies on whole dots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from tatamu.base.files import replacing
from tatamu.cameras.board import BAR, COLUMNS, MARKERS, PAPERS, ROWS, SQUARE, TOP, Board

DOTS = 20_000
"""Number of dots per metre of a printed page."""
LINE = 0.0003
"""Width of printed lines [m]."""


def page(board: Board, number: int) -> Image.Image:
    """Return a page of the board as a grey picture with 20 dots per millimetre. The first page has number 0."""
    wide, tall = (round(side * DOTS) for side in PAPERS[board.paper])
    sheet = Image.new("L", (wide, tall), 255)
    size = (round(COLUMNS * SQUARE * DOTS), round(ROWS * SQUARE * DOTS))
    left, top = (wide - size[0]) // 2, round(TOP * DOTS)
    sheet.paste(Image.fromarray(board.pattern(number).generateImage(size)), (left, top))
    canvas = ImageDraw.Draw(sheet)
    bottom, right = top + size[1], left + size[0]
    for x, y, name in ((left, bottom, "A"), (right, bottom, "B"), (left, top, "C")):
        _mark(canvas, x, y, 1 if x == right else -1, 1 if y == bottom else -1, name if number == 0 else "")
    _bar(canvas, (wide - round(BAR * DOTS)) // 2, bottom + round(0.009 * DOTS))
    text = (
        f"tatamu board, page {number + 1} of {board.pages}: {1e3 * SQUARE:.0f} mm squares, "
        f"markers {MARKERS * number} to {MARKERS * (number + 1) - 1}. Print at 100 %, lay it flat."
    )
    canvas.text((wide // 2, bottom + round(0.017 * DOTS)), text, 0, _font(), anchor="mt")
    return sheet


def write_pdf(board: Board, path: Path) -> None:
    """Write all pages of a board as a PDF file at their true size."""
    first, *others = (page(board, number).convert("1") for number in range(board.pages))
    with replacing(path) as temporary:
        dated: dict[str, Any] = {
            "creationDate": None,
            "modDate": None,
            "title": "tatamu board",
        }  # without dates, the same board always makes the same file
        first.save(temporary, "PDF", resolution=DOTS * 0.0254, save_all=True, append_images=others, **dated)


def _mark(canvas: Any, x: int, y: int, right: int, down: int, name: str) -> None:
    """Draw a mark of the board: two lines outwards from a corner of the pattern, and the letter `name`."""
    long, wide = round(0.005 * DOTS), round(LINE * DOTS)
    canvas.line([(x, y), (x + right * long, y)], 0, wide)
    canvas.line([(x, y), (x, y + down * long)], 0, wide)
    canvas.text((x + right * 0.7 * long, y + down * 0.8 * long), name, 0, _font(), anchor="mm")


def _bar(canvas: Any, left: int, y: int) -> None:
    """Draw the scale bar of the board, with a tick every centimetre."""
    long, wide = round(BAR * DOTS), round(LINE * DOTS)
    canvas.line([(left, y), (left + long, y)], 0, wide)
    for tick in np.arange(0.0, BAR + 1e-9, 0.01):
        high = round((0.004 if tick in (0.0, BAR) else 0.002) * DOTS)
        x = left + round(tick * DOTS)
        canvas.line([(x, y - high), (x, y)], 0, wide)
    canvas.text((left + long // 2, y + round(0.0015 * DOTS)), f"{1e3 * BAR:.0f} mm", 0, _font(), anchor="mt")


def _font() -> Any:
    return ImageFont.load_default(0.0038 * DOTS)
