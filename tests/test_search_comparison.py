"""The comparison of searches: it resumes where it stopped, and its tables have medians and worsts."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from studies.search import courses, methods, settings, tables

from tatamu.base.files import write_text

TOWEL = settings.Coarse("towel", "half", 0.05)


def test_what_was_simulated_and_studied_is_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    studies = courses.Studies(tmp_path)
    for name in ("random", "sobol", "grid", "lm"):
        studies.run(name, settings.Setting("towel", TOWEL, tmp_path / "rollouts"), 0, 3)
    again = settings.Setting("towel", TOWEL, tmp_path / "rollouts")
    monkeypatch.setattr("studies.search.settings.Nominal.fixed", None)
    before = {path.name: path.read_bytes() for path in (tmp_path / "studies").iterdir()}
    for path in (tmp_path / "studies").iterdir():
        path.unlink()
    for name in ("random", "sobol", "grid", "lm"):
        courses.Studies(tmp_path).run(name, again, 0, 3)
    assert {path.name: path.read_bytes() for path in (tmp_path / "studies").iterdir()} == before


def test_the_grid_leans_the_whole_curve_about_the_line_from_grasp_to_release(tmp_path: Path) -> None:
    setting = settings.Setting("towel", TOWEL, tmp_path)
    seen = set()
    for number in range(methods.MANY):
        parameters, manipulation = methods.grid(setting, 0, number, [])
        seen.add((parameters["height"], parameters["tilt"]))
        assert manipulation.control_points is not None
        control = manipulation.control_points[0]
        middle = 1.5 * control[1]
        away = middle - 0.5 * control[3]
        assert control[2] == pytest.approx((control[3] + 2.0 * middle) / 3.0), "a quadratic curve"
        assert np.linalg.norm(away) == pytest.approx(parameters["height"] * setting.fold.span)
        assert away[2] == pytest.approx(np.cos(parameters["tilt"]) * parameters["height"] * setting.fold.span)
    assert len(seen) == methods.MANY


def test_a_table_has_the_median_and_the_worst_of_the_seeds_that_are_there(tmp_path: Path) -> None:
    studies = courses.Studies(tmp_path)
    for seed, least in enumerate((0.9, 0.7, 0.8)):
        course = [{"objective": 1.0, "distance": 0.01}] * 9 + [{"objective": least, "distance": least / 100}] * 41
        write_text(studies._path("towel", "gp", seed), json.dumps(course))
    (row,) = tables.table(studies, "towel", 10)
    assert row["seeds"] == "3"
    assert row["C 5"] == "1.000, 1.000" and row["C 10"] == row["C 50"] == "0.800, 0.900" and row["C 134"] == "-"
    assert row["mm 10"] == "8.0, 9.0"
    assert tables.pair_table(studies, 10) == []
