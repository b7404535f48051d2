"""The house does not grow unnoticed: the sizes that `python -m tests.rooms` prints."""

from __future__ import annotations

import pytest

from tests import rooms
from tests.test_structure import SOURCE

ROOT = SOURCE.parents[1]
GROWTH = 1.03
CODE, DOCSTRINGS, CHECKS = 31_700, 8_580, 27_500
"""Lines of code and of docstrings in src, and lines of code in tests, benchmarks and studies together."""


@pytest.mark.parametrize(
    ("folders", "field", "allowed"),
    [
        (("src/tatamu",), "code", CODE),
        (("src/tatamu",), "docstrings", DOCSTRINGS),
        (("tests", "benchmarks", "studies"), "code", CHECKS),
    ],
)
def test_no_part_grows_by_more_than_three_per_cent(folders: tuple[str, ...], field: str, allowed: int) -> None:
    lines = sum(getattr(rooms.size_of(ROOT / folder), field) for folder in folders)
    assert lines <= GROWTH * allowed, f"{lines} lines of {field} in {', '.join(folders)}: delete some, or say why"
