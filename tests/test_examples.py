"""Every example runs and comes to the number that it promises."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any

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


def test_a_dropped_sheet_lies_half_a_thickness_high() -> None:
    assert main_of("01_drop_a_sheet")() == pytest.approx(0.0005, rel=0.05)


def test_a_hung_sheet_stretches_as_the_textbook_says() -> None:
    assert main_of("02_hang_by_the_edge")() == pytest.approx(1.0, rel=0.03)


def test_a_fold_by_hand_is_a_fold() -> None:
    assert main_of("03_fold_once")() < 0.02


def test_a_short_study_finds_a_fold(tmp_path: Path) -> None:
    assert main_of("04_learn_a_fold")(tmp_path) < 1.0


def test_a_skirt_of_ones_own_lies_in_two_layers(tmp_path: Path) -> None:
    assert main_of("05_your_own_garment")(tmp_path) == pytest.approx(0.0015, rel=0.1)


def test_a_towels_readings_give_its_bending_length() -> None:
    assert main_of("06_calibrate")() == pytest.approx(0.026, rel=0.05)


def test_an_objective_of_ones_own_decides_what_is_learned() -> None:
    assert main_of("07_your_own_objective")() > 0.02


def test_a_search_of_ones_own_finds_better_folds() -> None:
    assert main_of("08_your_own_search")() < 0.98


def test_a_garment_that_a_program_makes_is_folded() -> None:
    assert main_of("09_your_own_garment")() < 0.0125


def test_a_simulator_of_ones_own_simulates_folds() -> None:
    assert main_of("10_your_own_simulator")() > 0.001


def test_a_study_is_a_table_of_its_trials() -> None:
    assert main_of("11_trials_as_a_table")() == 6


def test_a_folding_board_folds_a_towel() -> None:
    assert main_of("12_folding_board")() < 0.05


def test_a_towel_on_a_drawing_is_found() -> None:
    assert main_of("16_find_the_cloth")() < 0.002


def test_no_example_is_forgotten() -> None:
    tested = Path(__file__).read_text()
    assert all(path.stem in tested for path in EXAMPLES.glob("*.py"))


@pytest.mark.slow
def test_an_observed_fold_is_corrected(tmp_path: Path) -> None:
    assert main_of("13_observe")(tmp_path / "towel") < 0.8
