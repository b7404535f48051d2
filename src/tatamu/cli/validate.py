"""The command `tatamu validate` of version 0.2."""

from __future__ import annotations

from tatamu.base.errors import InputError
from tatamu.cli.app import app


@app.command(hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def validate() -> None:
    """Say what has replaced the command."""
    raise InputError("validate: is now `python -m tests.physics` in a checkout of tatamu")
