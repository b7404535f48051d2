"""Print the oldest versions that pyproject.toml allows, as constraints of pip: `python -m tests.oldest`."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parent.parent / "pyproject.toml"
EXTRAS = ("report", "garments", "learn", "photo", "gym")
"""Extras whose oldest versions are tried; robots, clusters and the tools of developers keep theirs."""


def oldest() -> list[str]:
    """Requirements such as numpy==2.0."""
    project = tomllib.loads(PROJECT.read_text())["project"]
    extras = project["optional-dependencies"]
    given = [*project["dependencies"], *(package for extra in EXTRAS for package in extras[extra])]
    found = (re.match(r"([\w.-]+)(?:\[\w+\])?>=([\w.]+)", package) for package in given)
    return [f"{match[1]}=={match[2]}" for match in found if match]


if __name__ == "__main__":
    print("\n".join(oldest()))
