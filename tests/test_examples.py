"""Every example runs and comes to the number that it promises."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import garments
from tatamu.search import search
from tatamu.simulation import simulators

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.fixture(autouse=True)
def _own_registries(monkeypatch: pytest.MonkeyPatch) -> None:
    """What an example registers is gone after its test."""
    for module, names in (
        (garments, ("GARMENTS", "DESCRIPTIONS")),
        (simulators, ("SIMULATORS",)),
        (search, ("_REGISTERED",)),
    ):
        for name in names:
            monkeypatch.setattr(module, name, dict(getattr(module, name)))


def main_of(name: str) -> Callable[..., float]:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec and spec.loader
    module: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    main: Callable[..., float] = module.main
    return main


KEEPS_FILES = ("04_learn_a_fold", "05_your_own_garment", "13_observe")
"""Examples that are given a folder."""


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        pytest.param("01_drop_a_sheet", 0.95 * 0.0005, 1.05 * 0.0005, id="lies half a thickness high"),
        pytest.param("02_hang_by_the_edge", 0.97, 1.03, id="stretches as the textbook says"),
        pytest.param("03_fold_once", -np.inf, 0.02, id="is a fold"),
        pytest.param("04_learn_a_fold", -np.inf, 1.0, id="a short study finds a fold"),
        pytest.param("05_your_own_garment", 0.9 * 0.0015, 1.1 * 0.0015, id="a skirt lies in two layers"),
        pytest.param("06_calibrate", 0.95 * 0.026, 1.05 * 0.026, id="readings give the bending length"),
        pytest.param("07_your_own_objective", 0.02, np.inf, id="it decides what is learned"),
        pytest.param("08_your_own_search", -np.inf, 0.98, id="it finds better folds"),
        pytest.param("09_your_own_garment", -np.inf, 0.0125, id="a garment of a program is folded"),
        pytest.param("10_your_own_simulator", 0.001, np.inf, id="it simulates folds"),
        pytest.param("11_trials_as_a_table", 6, 6, id="a row for each trial"),
        pytest.param("12_folding_board", -np.inf, 0.05, id="it folds a towel"),
        pytest.param("13_observe", -np.inf, 0.8, id="the fold is corrected", marks=pytest.mark.slow),
        pytest.param("16_find_the_cloth", -np.inf, 0.002, id="a towel on a drawing is found"),
    ],
)
def test_an_example_comes_to_its_number(name: str, low: float, high: float, tmp_path: Path) -> None:
    folder = [tmp_path] if name in KEEPS_FILES else []
    assert low <= main_of(name)(*folder) <= high


def test_no_example_is_forgotten() -> None:
    tested = Path(__file__).read_text()
    assert all(path.stem in tested for path in EXAMPLES.glob("*.py"))
