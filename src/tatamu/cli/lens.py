"""The command `tatamu lens`, which measures the lens of a camera from photographs of a board."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tatamu.cli.app import app


@app.command()
def lens(
    photos: Annotated[list[Path], typer.Argument(metavar="PHOTO..", help="Photos of the board, 4 to 40.")],
    board: Annotated[Path, typer.Option(metavar="BOARD.toml", help="The board.")],
    out: Annotated[Path, typer.Option(metavar="LENS.toml", help="File of the lens.")],
) -> None:
    """Find the focal length and distortion of a camera from photos of the board.

    Take the photos from different sides and angles, with the same zoom. Let the board fill much of each photo,
    including the photo's edges and corners.

    Example:
    `tatamu lens photos/*.jpg --board board.toml --out lens.toml`
    """
    from tatamu.base.files import check_targets
    from tatamu.cameras.board import load_board
    from tatamu.cameras.lens import calibrate_lens, write_lens
    from tatamu.cameras.photograph import board_corners

    check_targets([out], [*photos, board])
    seen, size = board_corners(photos, load_board(board))
    found, rms = calibrate_lens(seen, size)
    write_lens(found, out)
    print(f"lens: {out}, focal length {found.focal:.0f} pixels of {found.width} x {found.height}")
    print(f"corners deviate from the lens by {rms:.2f} pixels in {len(seen)} photos")
