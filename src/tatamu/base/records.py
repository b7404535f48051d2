"""Base classes for the contents of files. Records are immutable and validated, and all their numbers are finite."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, SerializerFunctionWrapHandler, model_serializer


class Record(BaseModel):
    """Base of records in files that users write. An unknown field is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, arbitrary_types_allowed=True)


class OpenRecord(BaseModel):
    """Base of records in files that tatamu writes and reads again. Fields from other versions are ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False, arbitrary_types_allowed=True)

    UNSAID: ClassVar[frozenset[str]] = frozenset()
    """Fields that are omitted in the file if they have their defaults."""

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
