"""Writes the results of the tests on real cloth as Markdown and as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from studies.real_cloth.section import Line, Section
from tatamu import __version__


def markdown(lines: Sequence[Line]) -> str:
    """Return a table as Markdown."""
    head = list(lines[0])
    rows = [[line[name].replace("|", "\\|") for name in head] for line in lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *rows])


def text(section: Section, tables: int | None = None) -> str:
    """Return the result of a test on real cloth as Markdown, with all of its tables or the first ones."""
    parts = [
        section.method,
        *(markdown(table.lines) for table in section.tables[:tables]),
        f"To beat: {section.beat}",
        f"Goal: {section.goal}",
        f"Cannot show: {section.silent}",
    ]
    return "\n\n".join(parts)


def page(sections: Sequence[Section], simulator: str) -> str:
    """Return a Markdown file with the results of all tests on real cloth."""
    head = f"# Real cloth, simulated by {simulator}\n\nMade by tatamu {__version__} from published measurements.\n"
    return "\n".join([head, *(f"## {section.title}\n\n{text(section)}\n" for section in sections)])


def data(sections: Sequence[Section], simulator: str) -> dict[str, Any]:
    """Return the results of all tests on real cloth as a dictionary for a JSON file."""
    return {
        "version": 1,
        "tatamu": __version__,
        "simulator": simulator,
        "sections": [
            {
                "name": section.name,
                "title": section.title,
                "goal": section.goal,
                "tables": {table.name: [dict(line) for line in table.lines] for table in section.tables},
            }
            for section in sections
        ],
    }
