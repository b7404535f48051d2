"""The commands `tatamu board` and `lens`, and the options of commands that read photographs.

In these photographs, a board or a sheet of paper next to the cloth gives the scale.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tatamu.base.errors import InputError

BoardOption = Annotated[
    Path | None, typer.Option(metavar="BOARD.toml", help="The board in the photo, from `tatamu board`.")
]
SheetOption = Annotated[
    str | None, typer.Option(help="Size of a plain white sheet in the photo, instead of a board: a4 or letter.")
]
LensOption = Annotated[Path | None, typer.Option(metavar="LENS.toml", help="The camera's lens, from `tatamu lens`.")]
CornerOption = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=X,Y", help="Correct pixel of a corner that was found in the wrong place; repeatable."),
]

JoinOption = Annotated[
    bool,
    typer.Option("--join", help="Treat everything that differs from the table as cloth, not only the largest part."),
]
PictureOption = Annotated[
    Path | None,
    typer.Option(metavar="PICTURE", help="Picture to write: the photo with the result drawn on it, .png or .jpg."),
]


def board(
    out: Path = typer.Option(..., metavar="BOARD.pdf", help="File to print; BOARD.toml is written beside it."),
    paper: str = typer.Option("a4", help="a4 or letter."),
    pages: int = typer.Option(
        1, help="Number of pages, 1 to 8. If the lens is unknown, put a second page on the other side of the cloth."
    ),
) -> None:
    """Make a board to print. The board lies next to the cloth in photographs, and gives their scale.

    Print the board at 100 %, and measure its scale bar with a ruler. If the bar is not 150 mm long, correct `bar` in
    the .toml file.

    Examples:
    `tatamu board --out board.pdf`

    `tatamu board --out board.pdf --paper letter --pages 2`
    """
    from tatamu.base.files import check_targets, validated
    from tatamu.cameras.board import BAR, SQUARE, Board, write_board, write_pdf

    if out.suffix.lower() != ".pdf":
        raise InputError(f"--out: must be a .pdf file, given {out}")
    described = out.with_suffix(".toml")
    made = validated(Board, {"paper": paper, "pages": pages}, "options")
    check_targets([out, described])
    write_pdf(made, out)
    write_board(made, described, out)
    width, height = 1e3 * made.size
    count = f"1 {paper} page" if pages == 1 else f"{pages} {paper} pages"
    print(f"board: {out}, {count} with a pattern of {width:.0f} x {height:.0f} mm")
    print(
        f"print the board at 100 %: squares must be {1e3 * SQUARE:.0f} mm wide and the scale bar "
        f"{1e3 * BAR:.0f} mm long"
    )
    print(f"file for --board: {described}; if the printed scale bar has another length, correct `bar` in this file")


def lens(
    photos: list[Path] = typer.Argument(..., metavar="PHOTO..", help="4 to 40 photos of the board."),
    board: Path = typer.Option(..., metavar="BOARD.toml", help="The board."),
    out: Path = typer.Option(..., metavar="LENS.toml", help="Lens file to write."),
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
    print(f"lens: {out}, focal length {found.focal:.0f} pixels, for photos of {found.width} x {found.height} pixels")
    print(f"error of the lens: {rms:.2f} pixels (root mean square over the board's corners in {len(seen)} photos)")


def scale_of(board: Path | None, sheet: str | None) -> Path | str:
    """Return what gives the scale of a photograph, a board or a sheet of paper.

    Raises:
        InputError: If none or both of them are given, or the sheet has an unknown size.
    """
    from tatamu.cameras.board import PAPERS

    if (board is None) == (sheet is None):
        raise InputError(f"--board, --sheet: exactly one is needed, given {'neither' if board is None else 'both'}")
    if sheet is not None and sheet not in PAPERS:
        raise InputError(f"--sheet: must be {' or '.join(PAPERS)}, given {sheet!r}")
    return board or str(sheet)
