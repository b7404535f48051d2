"""Tables of the docs, which the benchmarks write between marks."""

from __future__ import annotations

import re
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tatamu.base.files import read_json, read_text, write_json, write_text

IMAGES = Path("docs/images")
"""Folder of the pictures and drawings of the docs."""
PAGES = [Path("README.md"), *sorted(Path("docs").rglob("*.md"))]


Columns = Mapping[str, Callable[[Mapping[str, Any]], Any]]
"""What a table shows of a row, by the names of its columns."""
SCORES: Columns = {
    "mean distance [mm]": lambda row: f"{1e3 * row['mean_vertex_distance']:.2f}",
    "mask IoU": lambda row: f"{row['mask_iou']:.3f}",
    "E_f [%]": lambda row: f"{row['area_error']:.2f}",
    "slip [mm]": lambda row: f"{1e3 * row['slip']:.2f}",
    "residual bend [mm]": lambda row: f"{1e3 * row['residual_bend']:.1f}",
}
"""The measures of a fold."""


def arguments(text: str | None) -> ArgumentParser:
    """Return the parser of a benchmark's options, with `--write-docs`."""
    parser = ArgumentParser(description=text, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--write-docs", action="store_true", help="write the tables into the docs")
    return parser


def show(tables: Mapping[str, str | Sequence[Mapping[str, Any]]], write: bool) -> None:
    """Print tables, and put each between the marks of its name in the docs if asked."""
    for name, table in tables.items():
        text = table if isinstance(table, str) else markdown(table)
        print(f"{name}\n\n{text}\n", flush=True)
        if write:
            publish(name, text)


def kept(file: Path, find: Callable[[], Any]) -> Any:
    """Return what a JSON file keeps; if there is none, find it and keep it."""
    if not file.exists():
        write_json(file, find())
    return read_json(file)


def page_of(name: str) -> Path:
    """Return the page that has the marks `<!-- NAME -->` and `<!-- end -->`."""
    for page in PAGES:
        if f"<!-- {name} -->\n" in read_text(page):
            return page
    raise SystemExit(f"docs: no page has the marks <!-- {name} --> .. <!-- end -->")


def markdown(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows with the same keys as a Markdown table."""
    lines = ["| " + " | ".join(rows[0]) + " |", "|" + "---|" * len(rows[0])]
    cells = ([str(value).replace("|", "\\|") for value in row.values()] for row in rows)
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in cells])


def shown(rows: Sequence[Mapping[str, Any]], columns: Columns) -> list[dict[str, str]]:
    """Return what a table shows of rows."""
    return [{name: str(show(row)) for name, show in columns.items()} for row in rows]


def published(name: str) -> list[dict[str, str]]:
    """Return the rows of the table between the marks of that name in the docs; none if there is no table."""
    found = re.search(rf"<!-- {re.escape(name)} -->\n(.*?)<!-- end -->", read_text(page_of(name)), flags=re.S)
    lines = [line for line in found[1].splitlines() if line.startswith("| ")] if found else []
    head, *rows = ([cell.strip() for cell in line[1:-1].split("|")] for line in lines) if lines else [[]]
    return [dict(zip(head, cells, strict=True)) for cells in rows]


def merged(before: Sequence[dict[str, str]], rows: Sequence[dict[str, str]], *names: str) -> list[dict[str, str]]:
    """The rows of a table, those that were measured anew in the places of the old ones; new ones at the end.

    Args:
        before: The table.
        rows: Measured anew.
        names: Of the columns that tell one row from another.
    """
    found = {tuple(each[name] for name in names): each for each in (*before, *rows)}
    return list(found.values())


def publish(name: str, text: str) -> None:
    """Put a text between the marks of that name in the docs."""
    insert(name, text, page_of(name))


def insert(name: str, text: str, page: Path) -> None:
    """Put a text between the marks of that name of a page."""
    marks = rf"(<!-- {re.escape(name)} -->\n).*?(<!-- end -->)"
    write_text(page, re.sub(marks, lambda match: match[1] + text + "\n" + match[2], read_text(page), flags=re.S))
