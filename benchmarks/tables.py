"""Tables of docs/benchmarks.md, which the benchmarks write between marks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tatamu.files import read_text, write_text

PAGE = Path("docs/benchmarks.md")


def markdown(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows with the same keys as a Markdown table."""
    lines = ["| " + " | ".join(rows[0]) + " |", "|" + "---|" * len(rows[0])]
    cells = ([str(value).replace("|", "\\|") for value in row.values()] for row in rows)
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in cells])


def insert(name: str, text: str, page: Path = PAGE) -> None:
    """Put a text between the marks `<!-- NAME -->` and `<!-- end -->` of a page."""
    marks = rf"(<!-- {re.escape(name)} -->\n).*?(<!-- end -->)"
    written, found = re.subn(marks, lambda match: match[1] + text + "\n" + match[2], read_text(page), flags=re.S)
    if not found:
        raise SystemExit(f"{page}: has no marks <!-- {name} --> .. <!-- end -->")
    write_text(page, written)
