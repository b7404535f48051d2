"""The benchmarks time folds, and only what folded."""

from __future__ import annotations

import importlib
import re
from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

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
