"""Defines the typer application `app` with every command."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import typer

from tatamu.base.errors import InputError
from tatamu.base.version import __version__
from tatamu.cli.calibrate import calibrate
from tatamu.cli.check import check
from tatamu.cli.dataset import dataset, replay
from tatamu.cli.garments import garments, plans, show
from tatamu.cli.learn import learn
from tatamu.cli.locate import locate
from tatamu.cli.margins import margins
from tatamu.cli.materials import materials
from tatamu.cli.measure import measure
from tatamu.cli.observe import correct, observe
from tatamu.cli.outline import outline
from tatamu.cli.photographs import board, lens
from tatamu.cli.plan import plan
from tatamu.cli.rehearse import rehearse
from tatamu.cli.simulate import install, simulate
from tatamu.cli.sweep import sweep

app = typer.Typer(
    name="tatamu",
    help="Learn in simulation how a dual-arm robot folds cloth.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
COMMANDS: tuple[Callable[..., Any], ...] = (
    *(board, calibrate, check, dataset, replay, garments, install, learn, lens, locate, margins, materials, measure),
    *(observe, correct, outline, plan, plans, rehearse, show, simulate, sweep),
)
"""The commands in the order of `tatamu --help`."""
for command in COMMANDS:
    app.command()(command)


@app.command(hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def validate() -> None:
    """Refuse this former command, and name its successor."""
    raise InputError("validate: no longer exists; run `python -m tests.physics` in a checkout of tatamu")


def _version(value: bool) -> None:
    if value:
        print(__version__)
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    pass
