"""Sizes of the package, and the table of its rooms in docs/architecture.md: `python -m tests.rooms [--write-docs]`."""

from __future__ import annotations

import argparse
import ast
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from tests.test_structure import ORDER, SOURCE

PAGE = SOURCE.parents[1] / "docs" / "architecture.md"
START, END = "<!--rooms-->\n", "<!--end-->"


class Size(NamedTuple):
    """Lines of Python files."""

    code: int
    """Lines that are neither blank, nor a comment, nor a docstring."""
    docstrings: int
    lines: int
    files: int


def size_of(path: Path) -> Size:
    """Count the lines of a file, or of all Python files in a folder."""
    if path.is_dir():
        sizes = [size_of(file) for file in sorted(path.rglob("*.py"))]
        return Size(*(sum(column) for column in zip(*sizes, strict=True)))
    text = path.read_text()
    documented: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        body = getattr(node, "body", None)
        for each in body if isinstance(body, list) else []:
            if (
                isinstance(each, ast.Expr)
                and isinstance(each.value, ast.Constant)
                and isinstance(each.value.value, str)
            ):
                documented |= set(range(each.lineno, (each.end_lineno or each.lineno) + 1))
    written = {
        number for number, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")
    }
    return Size(len(written - documented), len(documented), len(text.splitlines()), 1)


def table() -> str:
    """Return the table of rooms: each with the first line of its docstring."""
    rows = ["| room | what it is |", "|---|---|"]
    for room in ORDER:
        text = import_module(f"tatamu.{room}").__doc__ or ""
        rows.append(f"| `{room}` | {text.splitlines()[0]} |")
    return "\n".join(rows) + "\n"


def main() -> None:
    """Print the sizes, or write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write-docs", action="store_true", help="write the table of rooms into docs/architecture.md")
    if parser.parse_args().write_docs:
        head, _, rest = PAGE.read_text().partition(START)
        PAGE.write_text(head + START + table() + END + rest.partition(END)[2])
    root = SOURCE.parents[1]
    folders = [SOURCE, *(SOURCE / room for room in ORDER if (SOURCE / room).is_dir())]
    folders += [root / name for name in ("tests", "benchmarks", "studies")]
    print(f"{'':12} {'files':>5} {'code':>6} {'docstrings':>10} {'lines':>6}")
    for folder in folders:
        size = size_of(folder)
        print(f"{folder.name:12} {size.files:5} {size.code:6} {size.docstrings:10} {size.lines:6}")


if __name__ == "__main__":
    main()
