"""The command line: parse, call, print. One module per command; each adds itself to `app`."""

from __future__ import annotations

from tatamu.cli import (  # noqa: F401
    board,
    calibrate,
    check,
    dataset,
    garments,
    install,
    learn,
    lens,
    locate,
    margins,
    materials,
    measure,
    observe,
    outline,
    plan,
    plans,
    rehearse,
    show,
    simulate,
    sweep,
    validate,
)
from tatamu.cli.app import app
from tatamu.cli.program import run


def main() -> None:
    """Run `tatamu`."""
    run(app, "tatamu")
