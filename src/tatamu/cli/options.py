"""Generates the options of commands from the fields of records in the library."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import typer
from pydantic.fields import FieldInfo

from tatamu.base.errors import InputError
from tatamu.base.records import Record
from tatamu.study.options import Options

PLAIN = (bool, int, float)
CONTEXT = "context"
"""Name of a command's parameter that receives typer's context. The context tells which options the user gave."""


Defaults = Callable[[Mapping[str, Any], bool], Mapping[str, Any]]
"""Function that returns values for options that the user did not give.

The function gets two arguments: the parameters of the command, and whether the user gave the command's argument.
"""


def options_from(
    record: type[Record], argument: str, defaults: Defaults | None = None
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Decorate a command so that its parameter `options` is replaced by one option for each field of a record.

    Args:
        record: Class of the record. Its fields define the defaults and the descriptions of the options.
        argument: Name of the field that is the argument of the command, not an option.
        defaults: Function that returns values for options that the user did not give. With such a function, the
            argument is optional. With None, the defaults of the record are used, and the argument is required.
    """

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        own = list(inspect.signature(command, eval_str=True).parameters.values())[1:]
        made = {name: _parameter(name, field, name == argument) for name, field in record.model_fields.items()}
        first = made.pop(argument)
        if defaults is not None:
            kind, shown = get_args(first.annotation)
            first = first.replace(default=None, annotation=Annotated[kind | None, shown])
        required = [each for each in own if each.default is inspect.Parameter.empty]
        optional = [each for each in own if each.default is not inspect.Parameter.empty]

        def generated(**given: Any) -> Any:
            values = {name: given.pop(name) for name in record.model_fields}
            if defaults is not None:
                context: typer.Context = given.pop(CONTEXT)
                usual = defaults(given, values[argument] is not None)
                values |= {name: value for name, value in usual.items() if not _is_given(context, name)}
            return command(parse(record, values), **given)

        generated.__name__, generated.__doc__ = command.__name__, command.__doc__
        ordered = [first, *required, *made.values(), *optional]
        if defaults is not None:
            ordered.append(inspect.Parameter(CONTEXT, inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context))
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
    """Return the command's parameter that corresponds to a field of a record."""
    extra = field.json_schema_extra
    metavar = str(extra["metavar"]) if isinstance(extra, dict) and "metavar" in extra else None
    if is_argument:
        shown: Any = typer.Argument(metavar=metavar, help=field.description)
        return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=Annotated[str, shown])
    kind = _plain_type(field)
    shown = typer.Option(metavar=metavar, help=field.description, show_default=field.default is not None)
    default = field.default if kind is not str or field.default is None else str(field.default)
    wanted: Any = kind | None if field.default is None else kind
    annotation: Any = Annotated[wanted, shown]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def _kinds(annotation: Any) -> list[Any]:
    """Return the types that a field allows, such as `int` and `str` for `int | str | None`.

    The type of None and the annotations that pydantic adds are left out.
    """
    if get_origin(annotation) is Annotated:
        return _kinds(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return [kind for each in get_args(annotation) for kind in _kinds(each) if kind is not NoneType]
    return [annotation]


def _plain_type(field: FieldInfo) -> type:
    """Return the type with which typer reads an option: the field's type if it is bool, int or float, otherwise str.

    `parse` later converts the texts to the other types.
    """
    kinds = _kinds(field.annotation)
    return kinds[0] if len(kinds) == 1 and kinds[0] in PLAIN else str


def parse(record: type[Record], given: Mapping[str, Any]) -> Any:
    """Make a record from the values of a command's options. Texts are converted to the types of the fields.

    Raises:
        InputError: If a value is wrong. The message names the option.
    """
    values = {name: _parsed(name, record.model_fields[name], value) for name, value in given.items()}
    assert issubclass(record, Options)
    return record(**values)


def _parsed(name: str, field: FieldInfo, value: Any) -> Any:
    numbers = [kind for kind in _kinds(field.annotation) if kind in PLAIN]
    words = [word for kind in _kinds(field.annotation) if get_origin(kind) is Literal for word in get_args(kind)]
    if not isinstance(value, str) or not numbers or not words or value in words:
        return value
    try:
        return numbers[0](value)
    except ValueError:
        kind = "a whole number" if numbers[0] is int else "a number"
        raise InputError(f"{name}: must be {kind} or {' or '.join(words)}, given {value!r}") from None
