"""The command `tatamu install`, which installs software that pip cannot install with tatamu."""

from __future__ import annotations

from typing import Annotated

import typer

from tatamu.base.errors import InputError
from tatamu.cli.app import app


@app.command()
def install(what: Annotated[str, typer.Argument(metavar="WHAT", help="What to install: blender.")]) -> None:
    """Install Blender (about 1 GB) in a folder where tatamu finds it, for the option `--simulator blender`.

    Example: `tatamu install blender`
    """
    if what != "blender":
        raise InputError(f"WHAT: must be blender, given {what!r}")
    from tatamu.simulation.blender.discovery import install as make

    print(f"blender: {make()}")
