"""Commands as a user types them, run in this process: a process of its own would only import everything again."""

from __future__ import annotations

import contextlib
import io
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from typer.testing import CliRunner

from tatamu.cli import main
from tatamu.cli.app import app


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    returncode: int
    stdout: str
    stderr: str


def tatamu(*arguments: str, cwd: Path | None = None) -> Ended:
    """Run `tatamu ARGUMENTS`, in the folder `cwd` if one is given."""
    out, err = io.StringIO(), io.StringIO()
    code: object = 0
    with (
        mock.patch("sys.argv", ["tatamu", *arguments]),
        contextlib.chdir(cwd or Path()),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as ended:
            code = ended.code or 0
    assert isinstance(code, int)
    return Ended(code, out.getvalue(), err.getvalue())


def refused(*arguments: str, cwd: Path | None = None) -> str:
    """Return the one line that `tatamu ARGUMENTS` writes on stderr; its exit code is 2."""
    ended = tatamu(*arguments, cwd=cwd)
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1), ended
    assert ended.stderr.startswith("tatamu: ")
    return ended.stderr


def command(*arguments: object) -> str:
    """Return what a command prints, or raise its error."""
    result = CliRunner().invoke(app, [*map(str, arguments)])
    if result.exception:
        raise result.exception
    return result.output
