"""What is said where something is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tatamu.base.errors import InputError


def refusal(call: Callable[..., Any], *arguments: Any, **named: Any) -> str:
    """Return the message of the `InputError` that a call raises, one line without control characters."""
    with pytest.raises(InputError) as error:
        call(*arguments, **named)
    said = str(error.value)
    assert said.isprintable(), said
    return said
