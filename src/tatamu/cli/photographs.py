"""Options of the commands that read a photograph in which a board or a sheet of paper gives the scale."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
