"""What Python prints of the big records: one line, without arrays."""

from __future__ import annotations

import pytest

import tatamu as tt
from tatamu.folding.trial_scene import scene_of
from tests.fabricated import write_fold


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = write_fold(tmp_path_factory.mktemp("fold") / "towel", spacing=0.08, frames=24)
    rollout = tt.Rollout.load(folder / "rollout.npz")
    task = tt.make_task("towel", spacing=0.08)
    manipulation = task.manipulation(task.space.middle())
    scene = scene_of(task.fold, manipulation)
    records = [task, task.fold, task.garment, manipulation, scene, scene.cloth, rollout]
    return {type(each).__name__: text for each in records for text in (repr(each), str(each))}


def test_big_records_take_one_line_that_names_them(printed: dict[str, str]) -> None:
    assert len(printed) == 7
    for name, text in printed.items():
        assert text.startswith(f"<{name}") and len(text) < 160 and "\n" not in text and "array" not in text


def test_the_line_says_what_it_is(printed: dict[str, str]) -> None:
    assert "fold half" in printed["Task"] and "grippers 2" in printed["Scene"] and "simulator native" in printed["Task"]
