"""The benchmarks time folds, and only what folded."""

from __future__ import annotations

import importlib
import re
from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom

from tatamu.simulation.rollout import Rollout
from tatamu.simulation.simulators import simulate

FOLDER = Path(__file__).parent.parent / "benchmarks"


@pytest.fixture
def modules(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(FOLDER.parent))
    return lambda name: importlib.import_module(f"benchmarks.{name}")


@pytest.mark.parametrize("kind", ["towel", "shirt"])
def test_native_folds_what_the_benchmark_times(modules: Any, kind: str) -> None:
    folds = modules("timed_folds")
    fold = getattr(folds, kind)(0.02)
    assert fold.distance(simulate(fold.scene)) < folds.FOLDED


def test_the_time_of_what_did_not_fold_is_not_given(
    modules: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    speed, rollouts = modules("speed"), modules("timed_rollouts")
    case = rollouts.Case("native", "towel", speed.HELD_OPEN, 0.04)
    cloth = case.fold.scene.cloth
    flat = Rollout(np.zeros(2), np.stack([cloth.vertices] * 2), cloth.faces, {"wall_seconds": 0.1})
    monkeypatch.setattr(rollouts, "run", lambda engine, scene: flat)
    rollouts.keep(tmp_path / case.file(0), rollouts.measure(case))
    (row,) = speed.compared([case], Namespace(runs=2, out=tmp_path, limit=1.0))
    assert row["seconds"] == "-" and row["runs"] == 0 and row["note"].startswith("did not fold")


def test_a_table_goes_between_its_marks(modules: Any, tmp_path: Path) -> None:
    tables, page = modules("tables"), tmp_path / "page.md"
    page.write_text("a\n<!-- one -->\nold\n<!-- end -->\nb\n<!-- two -->\n<!-- end -->\n")
    tables.insert("one", tables.markdown([{"x": "|1|"}]), page)
    assert (
        page.read_text() == "a\n<!-- one -->\n| x |\n|---|\n| \\|1\\| |\n<!-- end -->\nb\n<!-- two -->\n<!-- end -->\n"
    )


def test_rows_that_are_measured_anew_take_the_places_of_the_old_ones(
    modules: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    tables, page = modules("tables"), tmp_path / "page.md"
    rows = [{"fold": fold, "learned": "least C", "worst": "9"} for fold in ("towel", "leg")]
    page.write_text(f"<!-- one -->\n{tables.markdown(rows)}\n<!-- end -->\n<!-- two -->\n<!-- end -->\n")
    monkeypatch.setattr(tables, "PAGES", [page])
    assert tables.published("one") == rows and tables.published("two") == []
    with pytest.raises(SystemExit, match="no page has the marks"):
        tables.publish("three", "")
    new = [{**rows[0], "worst": "5"}, {**rows[0], "learned": "in disturbed worlds"}]
    assert tables.merged(rows, new, "fold", "learned") == [new[0], rows[1], new[1]]


def test_marks_of_the_docs_are_in_pairs_and_each_is_there_once(modules: Any) -> None:
    seen = []
    for page in modules("tables").PAGES:
        marks = re.findall(r"^<!-- (.+) -->$", (FOLDER.parent / page).read_text(), flags=re.M)
        assert marks[1::2] == ["end"] * (len(marks) // 2), page
        seen += marks[::2]
    assert len(set(seen)) == len(seen) > 0


def test_the_loop_of_a_simulated_cloth_is_that_of_its_bending_length(modules: Any) -> None:
    ruler, cloths = modules("ruler"), modules("cloths")
    material = cloths.load_material(Path("interlock"))
    height = ruler.loop_height("native", material, None)
    assert height == pytest.approx(0.906 * material.bending_length + 1.1 * material.thickness, rel=0.02)


def test_a_rollout_is_given_up_after_the_limit_and_kept(modules: Any, tmp_path: Path) -> None:
    rollouts = modules("timed_rollouts")
    case = rollouts.Case("native", "towel", modules("speed").HELD_OPEN, 0.02)
    first = rollouts.timed(case, 0, tmp_path, limit=0.05)
    assert first.note == "given up after 0.05 s"
    assert rollouts.timed(case, 0, tmp_path, limit=100.0).note == first.note
    assert not list(tmp_path.glob("*.part.npz"))


def test_the_same_shape_on_two_meshes_is_the_same(modules: Any) -> None:
    rollouts, folds = modules("timed_rollouts"), modules("timed_folds")
    shapes = []
    for spacing in (0.04, 0.03):
        fold = folds.towel(spacing)
        bent = fold.scene.cloth.vertices @ np.diag([0.5, 1.0, 1.0])
        rollout = Rollout(np.zeros(1), bent[None], fold.scene.cloth.faces, {})
        shapes.append(rollouts.shape_of(fold, rollout))
    assert np.allclose(shapes[0], shapes[1], atol=1e-9) and np.ptp(shapes[0][:, 0]) == pytest.approx(0.998 * 0.4)


def test_the_worst_case_of_a_check_stands_for_it(modules: Any) -> None:
    simulators = modules("simulators")

    def check(*errors: float | None) -> dict[str, Any]:
        row = {"quantity": "|sag|", "limit": 1.0, "unit": "%"}
        return {"cases": [{"case": f"{k}", "rows": [{**row, "error": error}]} for k, error in enumerate(errors)]}

    assert simulators.worst(check(0.2, 3.0, 1.0))["|sag|"]["error"] == 3.0
    assert simulators.worst(check(0.2, None, 1.0))["|sag|"]["error"] is None
    assert list(simulators.worst(check(0.2, 3.0), apart=True)) == ["0: |sag|", "1: |sag|"]
    found = {"one": {"hang": check(0.2, 0.5)}, "two": {"hang": check(1.5)}, "three": {"hang": check(None)}, "four": {}}
    (row,) = simulators.shortfalls(found)
    assert [row[name] for name in found] == ["0.5", "**1.5**", "**failed**", "-"]
    assert row["error of"] == "|sag|"  # a table of Markdown escapes it, once


def test_cloths_are_compared_by_what_all_finished(modules: Any) -> None:
    cloths = modules("cloths")
    row = {
        "preset": {"apart": [0.02, 0.04, None]},
        "three": {"apart": [0.02, 0.02, 0.05]},
        "four": {"apart": [0.01, 0.02, None]},
    }
    line = cloths.compared_line(cloths.cases()[0], row)
    assert line["with the preset: mean, median [mm]"] == "30.0, 30.0"
    assert line["three readings: ratios"] == "0.67, 0.67"
    assert line["and the loop: ratios"] == "0.50, 0.50"
    assert line["and the push: ratios"] == "-" and line["folds"] == "2"


def test_a_hidden_cloth_lies_within_the_spread_of_its_preset(modules: Any) -> None:
    cloths = modules("cloths")
    drawn, preset = cloths.another("interlock", 1), cloths.load_preset("interlock")
    for field, (low, high) in preset.spread.items():
        assert low <= getattr(drawn, field) <= high and getattr(drawn, field) != getattr(preset.material, field)


def test_crossings_of_folds_are_counted(modules: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    tangle = modules("tangle")
    made = iter([np.array([0, 3, 1]), None, np.array([0, 0, 0]), np.array([1, 0, 0])])
    monkeypatch.setattr(tangle, "crossings_of_fold", lambda simulate, seed, fast: next(made))
    row = tangle.line(True, 4)
    assert list(row.values()) == ["4 fast", 2, 1, 3, 1]


@pytest.mark.slow
def test_hidden_materials_come_back_with_honest_intervals(modules: Any, tmp_path: Path) -> None:
    module = modules("calibration")
    rows = module.recovery(tmp_path, draws=6, repeats=4)
    covers = []
    for name, limit in module.LIMITS.items():
        told = [row["rounded"][name] for row in rows if row["rounded"][name]["stated"] <= limit / 2]
        assert told and all(abs(each["error"]) <= limit for each in told if each["known"]), name
        covers += [each[name]["covers"] for row in rows for each in row["noisy"] if each[name]["known"]]
    low, high = binom.interval(0.99, len(covers), 0.6827)  # honest intervals fail this once in a hundred seeds
    assert low <= np.sum(covers) <= high
