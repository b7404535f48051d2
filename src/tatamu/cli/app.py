"""Defines the typer application `app`, to which every command is added."""

from __future__ import annotations

from typing import Annotated

import typer

from tatamu.base.version import __version__


class Interrupted(Exception):
    """Raised if the user ended a command with Ctrl-C.

    The text of this exception tells which results are saved, and how to resume the command.
    """


app = typer.Typer(
    name="tatamu",
    help="Learn in simulation how a dual-arm robot folds cloth.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(value: bool) -> None:
    if value:
        print(__version__)
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass
