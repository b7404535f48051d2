"""`tatamu measure`: instructions for measuring cloth with a ruler, a scale and a board."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tatamu.cli.app import app
from tatamu.errors import InputError


@app.command()
def measure(
    template: Annotated[
        str | None, typer.Option(metavar="GARMENT", help="Write a file to fill in: towel, tshirt, trousers, ...")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="FILE.toml", help="Where the template goes.")] = Path(
        "measurements.toml"
    ),
) -> None:
    """Say how to measure a garment, or write the file that the readings go into.

    Examples:
    `tatamu measure`

    `tatamu measure --template towel`

    `tatamu measure --template tshirt --out my-shirt.toml`
    """
    from tatamu.calibration.guide import instructions
    from tatamu.calibration.guide import template as text
    from tatamu.files import write_text

    if template is None:
        print(instructions(), end="")
        return
    content = text(template)
    if out.exists():
        raise InputError(f"{out}: is there already; remove it, or give another name with --out")
    write_text(out, content)
    print(f"{out}: fill in the readings, then `tatamu calibrate {out} --out MATERIAL.toml`; `tatamu measure` says how")
