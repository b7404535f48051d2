"""Options of the commands that read a photograph in which a board or a sheet of paper gives the scale."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tatamu.base.errors import InputError

BoardOption = Annotated[
    Path | None, typer.Option(metavar="BOARD.toml", help="The board in the photo, from `tatamu board`.")
]
SheetOption = Annotated[
    str | None, typer.Option(help="a4 or letter: a plain white sheet in the photo instead of a board.")
]
LensOption = Annotated[Path | None, typer.Option(metavar="LENS.toml", help="The camera's lens, from `tatamu lens`.")]
CornerOption = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=X,Y", help="Pixel of a corner, to correct what was found; may be given again."),
]


def scale_of(board: Path | None, sheet: str | None) -> Path | str:
    """Return what gives the scale of a photograph, a board or a sheet of paper.

    Raises:
        InputError: If none or both of them are given, or the sheet has an unknown size.
    """
    from tatamu.cameras.board import PAPERS

    if (board is None) == (sheet is None):
        raise InputError(f"board, sheet: exactly one must be given, given {0 if board is None else 2}")
    if sheet is not None and sheet not in PAPERS:
        raise InputError(f"sheet: must be {' or '.join(PAPERS)}, given {sheet!r}")
    return board or str(sheet)
