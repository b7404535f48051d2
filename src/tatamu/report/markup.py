"""HTML from values; every text that comes from a file goes through `text`."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from html import escape as text
from typing import Any

__all__ = ["filled", "inline", "rows", "table", "text"]


def filled(template: str, parts: Mapping[str, str]) -> str:
    """Put each part at its `{{name}}`, in one pass, so that what a part says is never read as a place.

    Raises:
        KeyError: The template names a part that is not given.
    """
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], template)


def inline(value: Any) -> str:
    """JSON for a script element, which no text inside can close."""
    packed = json.dumps(value, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    return packed.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def table(head: Iterable[str], body: Iterable[str], name: str = "") -> str:
    """A table that scrolls sideways where the page is narrow; cells are HTML already."""
    cells = "".join(f'<th scope="col">{cell}</th>' for cell in head)
    label = f' class="{name}"' if name else ""
    return (
        f'<div class="wide" tabindex="0"><table{label}><thead><tr>{cells}</tr></thead>'
        f"<tbody>{''.join(body)}</tbody></table></div>"
    )


def rows(pairs: Iterable[tuple[str, str]]) -> str:
    """A list of names and values, both plain text."""
    return "<dl>" + "".join(f"<dt>{text(name)}</dt><dd>{text(value)}</dd>" for name, value in pairs) + "</dl>"
