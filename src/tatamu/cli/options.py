"""The options of commands: those that several commands share, and those that are made from the fields of a record."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import typer
from pydantic.fields import FieldInfo
from typer.models import OptionInfo

from tatamu.base.errors import InputError
from tatamu.study.options import Options

SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Use the workers of a Dask scheduler (tcp://HOST:PORT), or N processes on this machine (local:N).",
    ),
]
StorageOption = Annotated[
    str | None,
    typer.Option(
        "--storage",
        metavar="URL",
        help="Database of the studies, postgresql://USER@HOST/DB; the password is read from PGPASSWORD or ~/.pgpass.",
    ),
]

MAX_AT_A_TIME = 256
"""Largest number of studies at a time, each of which takes a thread."""
PLAIN = (bool, int, float)
CONTEXT = "context"
"""Name of a command's parameter that receives typer's context. The context tells which options the user gave."""
Defaults = Callable[[Mapping[str, Any], bool], Mapping[str, Any]]
"""Function that returns values for options that the user did not give.

The function gets two arguments: the parameters of the command, and whether the user gave the command's argument.
"""


def at_a_time(executor: Executor | None, pending: int) -> int:
    """Return how many studies, each with `pending` trials at a time, keep all workers busy; 1 without workers."""
    threads = getattr(executor, "threads", None)
    if threads is None:
        return 1
    return min(MAX_AT_A_TIME, 1 + -(-2 * int(threads) // pending))  # for each thread, one trial runs and one waits


def options_from(
    record: type[Options], argument: str, defaults: Defaults
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Decorate a command so that its parameter `options` is replaced by one option for each field of a record.

    Args:
        record: Class of the record. Its fields define the defaults and the descriptions of the options.
        argument: Name of the field that is the optional argument of the command, not an option.
        defaults: Function that returns values for options that the user did not give.
    """

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        own = list(inspect.signature(command, eval_str=True).parameters.values())[1:]
        required = [each for each in own if isinstance(each.default, OptionInfo) and each.default.default is ...]
        optional = [each for each in own if each not in required]
        made = {name: _parameter(name, field, name == argument) for name, field in record.model_fields.items()}
        context = inspect.Parameter(CONTEXT, inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)

        def generated(**given: Any) -> Any:
            values = {name: given.pop(name) for name in record.model_fields}
            context: typer.Context = given.pop(CONTEXT)
            usual = defaults(given, values[argument] is not None)
            values |= {name: value for name, value in usual.items() if not _is_given(context, name)}
            parsed = {name: _parsed(name, record.model_fields[name], value) for name, value in values.items()}
            return command(record(**parsed), **given)

        generated.__name__, generated.__doc__ = command.__name__, command.__doc__
        ordered = [made.pop(argument), *required, *made.values(), *optional, context]
        generated.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
            [each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in ordered]
        )
        return generated

    return decorate


def _is_given(context: typer.Context, name: str) -> bool:
    """Return whether the user gave an option of the running command on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name not in ("DEFAULT", "DEFAULT_MAP")


def _parameter(name: str, field: FieldInfo, is_argument: bool) -> inspect.Parameter:
    """Return the command's parameter that corresponds to a field of a record.

    Typer reads the field's type if it is bool, int or float, otherwise a text, which `_parsed` converts.
    """
    extra = field.json_schema_extra
    metavar = str(extra["metavar"]) if isinstance(extra, dict) and "metavar" in extra else None
    kinds = _kinds(field.annotation)
    kind = kinds[0] if len(kinds) == 1 and kinds[0] in PLAIN else str
    default = None if is_argument else field.default
    if is_argument:
        shown: Any = typer.Argument(metavar=metavar, help=field.description)
    else:
        shown = typer.Option(metavar=metavar, help=field.description, show_default=default is not None)
    annotation: Any = Annotated[kind | None if default is None else kind, shown]
    usual = default if kind is not str or default is None else str(default)
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=usual, annotation=annotation)


def _kinds(annotation: Any) -> list[Any]:
    """Return the types that a field allows, such as `int` and `str` for `int | str | None`.

    The type of None and the annotations that pydantic adds are left out.
    """
    if get_origin(annotation) is Annotated:
        return _kinds(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return [kind for each in get_args(annotation) for kind in _kinds(each) if kind is not NoneType]
    return [annotation]


def _parsed(name: str, field: FieldInfo, value: Any) -> Any:
    """Return the value of an option, with a text converted to the type of the field.

    Raises:
        InputError: If the text is wrong. The message names the option.
    """
    numbers = [kind for kind in _kinds(field.annotation) if kind in PLAIN]
    words = [word for kind in _kinds(field.annotation) if get_origin(kind) is Literal for word in get_args(kind)]
    if not isinstance(value, str) or not numbers or not words or value in words:
        return value
    try:
        return numbers[0](value)
    except ValueError:
        kind = "a whole number" if numbers[0] is int else "a number"
        raise InputError(f"{name}: must be {kind} or {' or '.join(words)}, given {value!r}") from None
