"""Tables of the docs, which the benchmarks write between marks, and which page has which mark."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tatamu.base.files import read_text, write_text

NOTES = Path("docs/notes")
"""Folder of the pages with measured tables."""
GUIDE = Path("docs/guide")
"""Folder of the guide, whose pages have captures of what commands print."""
IMAGES = Path("docs/images")
"""Folder of the pictures and drawings of the docs."""
README = Path("README.md")
PLACES = {
    "capture: learn": GUIDE / "learning.md",
    "capture: plan": GUIDE / "plan.md",
    "capture: rehearse": GUIDE / "rehearse.md",
    "capture: calibrate": GUIDE / "calibration.md",
    "capture: margins": GUIDE / "margins.md",
    "capture: check": GUIDE / "second-opinion.md",
    "capture: observe": GUIDE / "observation.md",
    "gallery: garments": Path("docs/gallery.md"),
    "gallery: robots": Path("docs/gallery.md"),
    "earned: short": README,
    "earned": NOTES / "margins.md",
    "speed: short": README,
    "learning: long": NOTES / "learning.md",
    "coarser": NOTES / "learning.md",
    "coarser: later steps": NOTES / "learning.md",
    "coarser: disturbed worlds": NOTES / "learning.md",
    "loop": NOTES / "learning.md",
    "times": NOTES / "learning.md",
    "search: towel": NOTES / "search.md",
    "search: T-shirt": NOTES / "search.md",
    "search: trousers": NOTES / "search.md",
    "search: trousers, softer": NOTES / "search.md",
    "search: answers": NOTES / "search.md",
    "search: pair": NOTES / "search.md",
    "targets": NOTES / "folds.md",
    "folds": NOTES / "folds.md",
    "pressed": NOTES / "folds.md",
    "fabrics": NOTES / "garments.md",
    "foreign": NOTES / "garments.md",
    "own garments": NOTES / "own-garments.md",
    "calibration: pinch": NOTES / "calibration.md",
    "calibration: recovery": NOTES / "calibration.md",
    "calibration: readings": NOTES / "calibration.md",
    "calibration: cloths": NOTES / "calibration.md",
    "results": NOTES / "validation.md",
    "tangle": NOTES / "validation.md",
    "tangle: pokes": NOTES / "validation.md",
    "real: drape": NOTES / "real-cloth.md",
    "real: asked rigidity": NOTES / "real-cloth.md",
    "real: leeds": NOTES / "real-cloth.md",
    "real: motion": NOTES / "real-cloth.md",
    "real: towel": NOTES / "real-cloth.md",
    "real: seen nodes": NOTES / "real-cloth.md",
    "real: decrement": NOTES / "real-cloth.md",
    "real: terms": NOTES / "real-cloth.md",
    "real: cost": NOTES / "real-cloth.md",
    "statics": NOTES / "native.md",
    "locking": NOTES / "native.md",
    "towel": NOTES / "benchmarks.md",
    "shirt": NOTES / "benchmarks.md",
    "growth": NOTES / "benchmarks.md",
    "answer": NOTES / "benchmarks.md",
    "stepping": NOTES / "benchmarks.md",
    "throughput": NOTES / "benchmarks.md",
    "startup": NOTES / "benchmarks.md",
    "abuse": NOTES / "benchmarks.md",
    "checks": NOTES / "simulators.md",
    "fold": NOTES / "simulators.md",
    "agreement: small": NOTES / "second-opinion.md",
    "agreement: small, each": NOTES / "second-opinion.md",
    "agreement: towel": NOTES / "second-opinion.md",
    "agreement: towel, each": NOTES / "second-opinion.md",
    "run": NOTES / "reproduction.md",
    "outcomes": NOTES / "reproduction.md",
    "answers": NOTES / "reproduction.md",
    "cloth": NOTES / "reproduction.md",
    "time": NOTES / "reproduction.md",
    "cluster: storm": NOTES / "cluster.md",
    "cluster: overhead": NOTES / "cluster.md",
    "cluster: busy": NOTES / "cluster.md",
    "cluster: constants": NOTES / "cluster.md",
    "cluster: thousand": NOTES / "cluster.md",
    "garments within reach": NOTES / "robots.md",
    "presets": NOTES / "robots.md",
    "photographs: scale": NOTES / "photographs.md",
    "photographs: look": NOTES / "photographs.md",
    "photographs: folds": NOTES / "photographs.md",
    "grasps": NOTES / "robots.md",
    "loop closed": NOTES / "observation.md",
    "loop closed: commands": NOTES / "observation.md",
    "loop closed: updates": NOTES / "observation.md",
    "datasets: speed": NOTES / "datasets.md",
    "datasets: pictures": NOTES / "datasets.md",
    "datasets: read back": NOTES / "datasets.md",
    "datasets: policy": NOTES / "datasets.md",
    "margins: meshes": NOTES / "margins.md",
    "margins: folds": NOTES / "margins.md",
    "margins: simulators": NOTES / "margins.md",
    "margins: two meshes": NOTES / "margins.md",
    "fingers: folds": NOTES / "fingers.md",
    "fingers: cost": NOTES / "fingers.md",
    "fingers: hands": NOTES / "fingers.md",
}
"""The page of each table, by the name of its marks."""


def markdown(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows with the same keys as a Markdown table."""
    lines = ["| " + " | ".join(rows[0]) + " |", "|" + "---|" * len(rows[0])]
    cells = ([str(value).replace("|", "\\|") for value in row.values()] for row in rows)
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in cells])


def published(name: str) -> list[dict[str, str]]:
    """Return the rows of the table between the marks of that name in the docs; none if there is no table."""
    found = re.search(rf"<!-- {re.escape(name)} -->\n(.*?)<!-- end -->", read_text(PLACES[name]), flags=re.S)
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
    insert(name, text, PLACES[name])


def insert(name: str, text: str, page: Path) -> None:
    """Put a text between the marks `<!-- NAME -->` and `<!-- end -->` of a page."""
    marks = rf"(<!-- {re.escape(name)} -->\n).*?(<!-- end -->)"
    written, found = re.subn(marks, lambda match: match[1] + text + "\n" + match[2], read_text(page), flags=re.S)
    if not found:
        raise SystemExit(f"{page}: has no marks <!-- {name} --> .. <!-- end -->")
    write_text(page, written)
