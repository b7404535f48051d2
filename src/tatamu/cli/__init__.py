"""The command line `tatamu`.

The modules of this package define the commands, and add them to the application `app`. A command parses its arguments,
calls the library and prints the result.
"""

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
    """Run the command line `tatamu`."""
    run(app, "tatamu")
