"""The command line `tatamu`.

The modules of this package define the commands, of which `app` is made. A command parses its arguments, calls the
library and prints the result.
"""

from __future__ import annotations

from tatamu.cli.app import app
from tatamu.cli.program import run


def main() -> None:
    """Run the command line `tatamu`."""
    run(app, "tatamu")
