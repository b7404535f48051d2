"""Loads and runs the tests on real cloth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from studies.real_cloth.bench import Bench
from studies.real_cloth.registry import TESTS
from studies.real_cloth.section import Section
from studies.real_cloth.test import RealTest
from tatamu.base.errors import InputError

Loaded = list[tuple[RealTest, Any]]
"""List of chosen tests, each with its measurements."""


def load(data: Path, only: Sequence[str] = ()) -> Loaded:
    """Return the tests on real cloth that are named in `only`, each with its measurements.

    If `only` is empty, all tests are returned.

    Raises:
        InputError: If the folder, a test or a file does not exist, or a file is wrong.
    """
    for name in only:
        if name not in TESTS:
            raise InputError(f"--only: must be one of {', '.join(TESTS)}, given {name!r}")
    if not data.is_dir():
        raise InputError(f"{data}: must be a folder with measurements of real cloth (docs/guide/studies.md)")
    return [(test, test.load(data)) for name, test in TESTS.items() if not only or name in only]


def run(tests: Loaded, bench: Bench, done: Callable[[Section], None] = lambda section: None) -> list[Section]:
    """Run tests on real cloth one after the other.

    Args:
        tests: Tests with their measurements, from `load`.
        bench: Bench that simulates the experiments of the tests.
        done: Function that is called with the result of each test.
    """
    sections = []
    for test, measured in tests:
        sections.append(test.run(measured, replace(bench, folder=bench.folder / test.name)))
        done(sections[-1])
    return sections


def simulations(tests: Loaded, bench: Bench) -> int:
    """Return the approximate number of simulations that some tests on real cloth need together."""
    return sum(test.simulations(measured, bench) for test, measured in tests)
