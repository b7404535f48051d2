"""The command `tatamu board`, which makes a board to print.

The board lies next to the cloth in photographs, and gives them their scale.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tatamu.base.errors import InputError
from tatamu.cli.app import app


@app.command()
def board(
    out: Annotated[Path, typer.Option(metavar="BOARD.pdf", help="File to print; BOARD.toml is written beside it.")],
    paper: Annotated[str, typer.Option(help="a4 or letter.")] = "a4",
    pages: Annotated[
        int,
        typer.Option(help="Pages, 1 to 8. A second page on the other side of the cloth makes up for an unknown lens."),
    ] = 1,
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
    count = "1 page" if pages == 1 else f"{pages} pages"
    print(f"board: {out}, {count} of {paper}, a pattern of {width:.0f} x {height:.0f} mm")
    print(f"print the board at 100 %: squares are {1e3 * SQUARE:.0f} mm wide, the scale bar is {1e3 * BAR:.0f} mm long")
    print(f"file: {described}, for --board; if the printed bar has another length, correct `bar` in this file")
