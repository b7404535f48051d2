"""Find a towel on a photo: here a drawing of one, seen from straight above at a millimetre per pixel.

python examples/16_find_the_cloth.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image, ImageDraw

import tatamu as tt
from tatamu.cameras.board import Board, page, write_board

PLACE, YAW = np.array([0.45, 0.20]), np.radians(15.0)
"""Where the towel lies in the board's frame, from mark A [m], and how it is turned [rad]."""
SIZE = (0.24, 0.40)
"""Width and length of the towel [m]."""
BOARD_POSE = (0.30, -0.25, 0.0)
"""Pose of the board in the robot's base frame [m, m, rad]: measured with a ruler, or by touching its marks."""


def photo(board: Board) -> Image.Image:
    """Draw what a camera straight above would see."""
    image = Image.new("RGB", (1000, 800), (150, 110, 75))
    paper = page(board, 0).resize((210, 297), Image.Resampling.LANCZOS)
    image.paste(paper, (60, 440))
    mark = np.array([60 + 15, 440 + 12 + 240])  # A, the lower left corner of the pattern
    turn = np.array([[np.cos(YAW), -np.sin(YAW)], [np.sin(YAW), np.cos(YAW)]])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(SIZE)[::-1] / 2 @ turn.T + PLACE
    pixels = mark + 1000 * corners * [1, -1] - 0.5
    ImageDraw.Draw(image).polygon([tuple(pixel) for pixel in pixels], (60, 90, 170))
    return image


def main(folder: Path | None = None) -> float:
    """Find it, print its pose, and return how far it is from the truth [m]."""
    with TemporaryDirectory() as temporary:
        out = folder or Path(temporary)
        board = Board()
        write_board(board, out / "board.toml", out / "board.pdf")
        photo(board).save(out / "photo.png")
        found = tt.locate(out / "photo.png", out / "board.toml", size=SIZE, board_pose=BOARD_POSE)
    print("\n".join(found.lines()))
    return float(np.hypot(found.pose.x - PLACE[0], found.pose.y - PLACE[1]))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
