"""Runs a command line, and handles its failures.

A failure gives an exit code, and one line on standard error.
"""

from __future__ import annotations

import errno
import io
import os
import sys
import warnings
from typing import NoReturn

import typer

from tatamu.base.errors import InputError, TatamuError, one_line
from tatamu.base.extras import missing

INTERRUPTED = 130
"""Exit code of a program that was ended by Ctrl-C (128 + SIGINT)."""
FORMER = {"--quantile": 1, "--coarse": 0, "--no-coarse": 0, "--fine": 0}
"""Options of version 0.2 without an effect, and how many words follow each. They are accepted for one version."""


class Interrupted(Exception):
    """Raised if the user ended a command with Ctrl-C.

    The text of this exception tells which results are saved, and how to resume the command.
    """


def run(app: typer.Typer, name: str) -> NoReturn:
    """Run a command line. A wrong input gives one line on standard error and the exit code 2.

    Args:
        app: Application with all commands.
        name: Name of the program. Every message on standard error begins with this name.
    """
    _open_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters shows question marks
    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # users cannot act on warnings of libraries; `python -W` shows them
    threads = os.environ.get("NUMBA_NUM_THREADS", "1")
    if not (threads.isdecimal() and int(threads) > 0):  # numba would end with a traceback when it is imported
        _stop(name, f"NUMBA_NUM_THREADS: must be a whole number of 1 or more, given {threads!r}", 2)
    try:
        sys.argv[1:] = _without_former(name, sys.argv[1:])
        code = app(standalone_mode=False)
        sys.stdout.flush()
    except InputError as error:
        _stop(name, str(error), 2)
    except TatamuError as error:
        _stop(name, str(error), 1)
    except Interrupted as error:
        _stop(name, str(error), INTERRUPTED)
    except typer.Abort:
        _stop(name, "aborted", INTERRUPTED)
    except KeyboardInterrupt:
        code = INTERRUPTED  # the code that typer returns if it catches the exception first
    except ModuleNotFoundError as error:
        refused = missing(error)
        if refused is None:
            raise
        _stop(name, str(refused), 2)
    except MemoryError:
        _stop(name, "not enough memory; give smaller files or a larger mesh spacing", 2)
    except OSError as error:
        if error.filename is not None and error.errno in (errno.ENAMETOOLONG, errno.EACCES, errno.EPERM):
            _stop(name, f"{error.filename}: cannot be read or written ({error.strerror})", 2)
        full_broken_or_closed = (errno.ENOSPC, errno.EIO, errno.EPIPE)
        if error.errno not in full_broken_or_closed:  # errors of other files are reported where they are opened
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the rest of the output is dropped
        _stop(name, f"the output cannot be written ({error.strerror})", 1)
    except Exception as error:
        if not hasattr(error, "format_message"):
            raise
        _stop(name, error.format_message(), 2)
    if code == INTERRUPTED:
        _stop(name, "interrupted; finished work is kept", INTERRUPTED)
    sys.exit(code if isinstance(code, int) else 0)


def _without_former(name: str, words: list[str]) -> list[str]:
    """Return the words of a command line without former options, and say what became of those."""
    left = []
    following = iter(words)
    for word in following:
        option, _, value = word.partition("=")
        if words[0] not in ("learn", "margins") or option not in FORMER:
            left.append(word)
            continue
        if FORMER[option] and not value:
            next(following, None)
        now = "set the disturbances with --level" if option == "--quantile" else "set the mesh with --spacing"
        print(f"{name}: {option}: no longer has an effect; {now}", file=sys.stderr)
    return left


def _open_streams() -> None:
    """Open the null device for each standard stream that a service or `pythonw` has not opened.

    A file that is opened later would otherwise get the number of the stream, and receive what libraries write to it.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))
            os.set_inheritable(getattr(sys, name).fileno(), True)


def _stop(name: str, message: str, code: int) -> NoReturn:
    if message:  # a program without arguments has printed its help
        print(f"{name}: {one_line(message)}", file=sys.stderr)
    sys.exit(code)
