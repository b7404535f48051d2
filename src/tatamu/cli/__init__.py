"""The command line: parse, call, print. One module per command; each adds itself to `app`."""

from __future__ import annotations

import errno
import io
import os
import sys
import warnings
from typing import NoReturn

import typer

from tatamu.cli import (  # noqa: F401
    calibrate,
    check,
    garments,
    install,
    learn,
    margins,
    materials,
    measure,
    outline,
    plan,
    plans,
    rehearse,
    reproduce,
    show,
    simulate,
    sweep,
    validate,
)
from tatamu.cli.app import Interrupted, app
from tatamu.errors import InputError, TatamuError, one_line

UNWRITABLE = (errno.ENOSPC, errno.EIO, errno.EPIPE)
"""Errors of standard output: it is full, broken, or nobody reads it."""
INTERRUPTED = 130
"""The exit code of a program that was ended by Ctrl-C: 128 + SIGINT."""


def main() -> None:
    """Run the command line; a wrong input is one line on standard error and exit code 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters shows question marks
    if not sys.warnoptions:
        warnings.simplefilter(
            "ignore"
        )  # of libraries: whoever uses a command cannot act on them; `python -W` shows them
    try:
        code = app(standalone_mode=False)
        sys.stdout.flush()
    except InputError as error:
        _stop(str(error), 2)
    except TatamuError as error:
        _stop(str(error), 1)
    except Interrupted as error:
        _stop(str(error), INTERRUPTED)
    except typer.Abort:
        _stop("aborted", INTERRUPTED)
    except KeyboardInterrupt:
        code = INTERRUPTED  # as typer says where it sees the exception first
    except MemoryError:
        _stop("there is not enough memory for this; give smaller files or a coarser mesh", 2)
    except OSError as error:
        if error.errno not in UNWRITABLE:  # errors of other files are reported where they are opened
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the rest of the output is dropped
        _stop(f"the output cannot be written ({error.strerror})", 1)
    except Exception as error:
        if not hasattr(error, "format_message"):
            raise
        _stop(error.format_message(), 2)
    if code == INTERRUPTED:
        _stop("interrupted; what was finished is kept", INTERRUPTED)
    sys.exit(code if isinstance(code, int) else 0)


def _stop(message: str, code: int) -> NoReturn:
    if message:  # `tatamu` alone has printed its help
        print(f"tatamu: {one_line(message)}", file=sys.stderr)
    sys.exit(code)
