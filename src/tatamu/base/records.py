"""Base classes for the contents of files. Records are immutable and validated, and all their numbers are finite."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, SerializerFunctionWrapHandler, model_serializer, model_validator

from tatamu.base.files import read_json, validated


class Record(BaseModel):
    """Base of records in files that users write. An unknown field is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, arbitrary_types_allowed=True)


class OpenRecord(BaseModel):
    """Base of records in files that tatamu writes and reads again. Fields from other versions are ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False, arbitrary_types_allowed=True)

    UNSAID: ClassVar[frozenset[str]] = frozenset()
    """Fields that are omitted in the file if they have their defaults."""
    FORMER: ClassVar[Mapping[str, str]] = {}
    """Names of fields in files of earlier versions, each with the present name."""

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a JSON file. Errors name the file and the field."""
        return validated(cls, read_json(path), path)

    @model_validator(mode="before")
    @classmethod
    def _read_former(cls, given: Any) -> Any:
        if isinstance(given, dict) and not cls.FORMER.keys().isdisjoint(given):
            return {**{name: given[former] for former, name in cls.FORMER.items() if former in given}, **given}
        return given

    @model_serializer(mode="wrap")
    def _plain(self, standard: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Return plain data in the order of the fields."""
        plain: dict[str, Any] = standard(self)
        for name in self.UNSAID:
            usual = type(self).model_fields[name].get_default(call_default_factory=True)
            value = getattr(self, name)
            if type(value) is type(usual) and value == usual:  # arrays have no default
                plain.pop(name, None)  # the field may have been excluded before
        return plain
