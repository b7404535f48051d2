"""The report of a learned fold, without a browser."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jinja2 import UndefinedError

from tatamu.base.errors import InputError
from tatamu.folding.score import Score
from tatamu.report.measures import MEASURES, grade
from tatamu.show.page import inline, render
from tatamu.simulation.rollout import Rollout
from tatamu.study.result import Result
from tests.fabricated import changed, report, rewritten, write_fold
from tests.pages import charts, replay, shown
from tests.refusals import refusal


def test_the_report_is_one_page_with_every_figure(folder: Path) -> None:
    out = report(folder)
    page = out.read_text()
    assert out == folder / "report.html"
    assert sorted(path.name for path in folder.iterdir()) == [
        "manipulation.json",
        "report.html",
        "result.json",
        "rollout.npz",
        "scene.json",
    ]
    places = charts(page)
    assert set(places) == {
        "map-0",
        "own-0",
        "moment-0",
        "moment-1",
        "moment-2",
        "objective-0",
        "distance-0",
        "paths-0",
    }
    assert all(f'id="{name}"' in page for name in places)
    assert "Towel, half fold" in page and "near perfect" in page
    assert "tatamu learn towel --out towel --size 0.34x0.8 --hands 2 --spacing 0.08 --disturbances none" in page
    assert "{{" not in page.split("<script")[0]


def test_the_page_names_nothing_that_must_be_fetched(folder: Path) -> None:
    page = report(folder).read_text()
    fetched = re.findall(r"""(?:src|href|url\()\s*=?\s*["']?(\w+:[^"')\s]{0,30})""", page)
    assert fetched and all(address.startswith("data:") for address in fetched)


def test_the_same_fold_gives_the_same_bytes(folder: Path) -> None:
    first = report(folder).read_bytes()
    assert report(folder).read_bytes() == first


def test_the_page_stays_small_for_a_fine_mesh(tmp_path: Path) -> None:
    folder = write_fold(tmp_path / "fine", spacing=0.0125, frames=277)
    assert report(folder).stat().st_size < 4_000_000


def test_texts_from_files_are_escaped(folder: Path) -> None:
    evil = "<script>alert(1)</script>&\"'"
    changed(folder / "result.json", lambda r: r["task"].update(garment=evil))
    changed(folder / "result.json", lambda r: r["baselines"][0].update(title=evil))
    changed(folder / "result.json", lambda r: r["trials"][4].update(error=evil))
    rewritten(folder, lambda a: a.update(info=np.array(json.dumps({"warnings": [evil], "version": evil}))))
    page = report(folder).read_text()
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page


@pytest.mark.parametrize(
    ("distance", "word"),
    [
        (0.0019, "near perfect"),
        (0.002, "good"),
        (0.0049, "good"),
        (0.0051, "fair"),
        (0.0199, "fair"),
        (0.0201, "failed"),
        (float("nan"), "failed"),
        (None, "failed"),
    ],
)
def test_grades_follow_the_thresholds(distance: float | None, word: str) -> None:
    assert grade(distance) == word


def test_measures_know_what_passes() -> None:
    passing = Score(**dict.fromkeys(Score.model_fields, 1.0) | {"mean_vertex_distance": 0.006, "mask_iou": 0.8})
    passing = passing.model_copy(update={"area_error": 2.77, "moving_vertex_distance": 0.012})
    far = {"mean_vertex_distance": 0.013, "moving_vertex_distance": 0.026}
    missing = passing.model_copy(update={**far, "mask_iou": 0.79, "area_error": 2.78})
    verdicts = {measure.key: (measure.passes(passing), measure.passes(missing)) for measure in MEASURES}
    for key in ("mean_vertex_distance", "moving_vertex_distance", "mask_iou", "area_error"):
        assert verdicts[key] == (True, False)
    assert verdicts["slip"] == (None, None)
    assert [measure.text(None) for measure in MEASURES] == ["–"] * len(MEASURES)


def test_the_table_shows_baselines_beside_the_learned_fold(folder: Path) -> None:
    page = report(folder).read_text()
    for title in ("Curve shipped with Li 2015&#39;s code", "Triangle", "Circular arc"):
        assert f'<th scope="col">{title}</th>' in page
    assert '<span class="pill failed">failed</span>' in page


def test_a_report_without_baselines_and_moments_still_has_its_histogram(folder: Path) -> None:
    changed(folder / "result.json", lambda r: r.pop("baselines"))
    rewritten(folder, lambda a: [a.pop(name) for name in ("error_first", "error_10", "error_50")])
    page = report(folder).read_text()
    assert "<b>Best of all 50</b>" in page and "<b>First trial</b>" not in page


@pytest.mark.parametrize("name", ["result.json", "manipulation.json", "scene.json", "rollout.npz"])
@pytest.mark.parametrize("broken", [None, "", "{", "[1]"])
def test_a_wrong_folder_is_refused_in_one_line_that_names_the_file(folder: Path, name: str, broken: str | None) -> None:
    if broken is None:
        (folder / name).unlink()
    else:
        (folder / name).write_text(broken)
    assert str(folder / name) in refusal(report, folder)
    assert not (folder / "report.html").exists()


@pytest.mark.parametrize(
    ("name", "change", "field"),
    [
        ("result.json", lambda r: r.update(version=2), "version"),
        ("result.json", lambda r: r.update(best=4), "best"),
        ("result.json", lambda r: r.update(best=99), "best"),
        ("result.json", lambda r: r["trials"][0].update(state="running"), "state"),
        ("result.json", lambda r: r["trials"][0].update(objective=None), "objective"),
        ("result.json", lambda r: r["baselines"][0].update(path=[[0, 0]]), "path"),
        ("manipulation.json", lambda m: m.update(version=7), "version"),
        ("manipulation.json", lambda m: m.update(arms=[]), "arms"),
        ("manipulation.json", lambda m: m["arms"][0].update(name="<b>"), "name"),
        ("manipulation.json", lambda m: m["via_points"]["left"][5].__setitem__(2, 0.9), "via_points.left"),
    ],
)
def test_a_wrong_field_is_named(
    folder: Path, name: str, change: Callable[[dict[str, Any]], object], field: str
) -> None:
    changed(folder / name, change)
    with pytest.raises(InputError, match=rf"{name}: .*{field}"):
        report(folder)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda a: a.pop("target"), "target"),
        (lambda a: a.update(target=a["target"][:-1]), "target"),
        (lambda a: a.update(error_10=a["error_10"][:-1]), "error_10"),
        (lambda a: a.update({"failed: slipped": a["target"][:-1]}), "failed: slipped must have shape"),
        (lambda a: a["positions"].__setitem__((-1, 0, 0), np.nan), "positions"),
        (lambda a: a.update(positions=a["positions"][:, :-1]), "faces must be vertex indices"),
        (lambda a: a.update(times=a["times"][::-1]), "times"),
        (lambda a: a.update(faces=a["faces"] + 1), "faces"),
        (lambda a: a.update(faces=a["faces"][:, :2]), "faces"),
    ],
)
def test_a_rollout_that_does_not_fit_is_refused(
    folder: Path, change: Callable[[dict[str, np.ndarray]], object], field: str
) -> None:
    rewritten(folder, change)
    with pytest.raises(InputError, match=rf"rollout\.npz: .*{field}"):
        report(folder)


def test_a_hand_that_has_no_gripper_is_refused(folder: Path) -> None:
    changed(folder / "scene.json", lambda s: s["grippers"][1].update(hand="left"))
    with pytest.raises(InputError, match="grippers: must contain the gripper of the right hand; learn the fold again"):
        report(folder)


def test_hands_follow_the_grippers_of_the_scene(folder: Path) -> None:
    fold = Result.load(folder)
    for arm in fold.arms:
        assert np.allclose(fold.hand(arm), fold.rollout.positions[:, arm.grasp.vertex], atol=1e-6)


def test_a_hand_whose_fingers_press_layers_together_is_drawn_on_its_own_way(folder: Path) -> None:
    fold = Result.load(folder)
    arm = fold.arms[0]
    way, vertex = fold.hand(arm), arm.grasp.vertex

    def press(scene: Any) -> None:
        whole = scene["grippers"][0]
        pressed = {
            **whole,
            "vertices": [vertex],
            "displacements": [[x, y, z - 0.02] for x, y, z in whole["displacements"]],
        }
        others = [each for each in whole["vertices"] if each != vertex]
        scene["grippers"][:1] = [{**whole, "vertices": others}, pressed]

    changed(folder / "scene.json", press)
    assert (Result.load(folder).hand(arm) == way).all()


def test_a_cloth_exactly_on_its_target_has_a_report_without_errors(folder: Path) -> None:
    rewritten(folder, lambda a: a["positions"].__setitem__(-1, a["target"]))
    page = report(folder).read_text()
    plots = charts(page)
    count = replay(page)["count"]
    assert plots["own-0"]["data"][0]["y"] == [count], "all vertices are in the first bin, and there is no other"
    errors = [value for row in plots["map-0"]["data"][0]["z"] for value in row if value is not None]
    assert len(errors) > 1000 and set(errors) == {0.0}
    frames = shown(replay(page))
    assert (frames[-2] == frames[-1]).all(), "the last frame of the replay is its target"


def test_a_scene_without_table_and_a_single_frame_have_a_report_that_rests(folder: Path) -> None:
    changed(folder / "scene.json", lambda s: s.update(table=None))
    rewritten(folder, lambda a: a.update(times=a["times"][:1], positions=a["positions"][:1]))
    rollout = Rollout.load(folder / "rollout.npz")
    assert len(rollout.times) == 1
    page = report(folder).read_text()
    data = replay(page)
    assert data["table"] is None and data["times"] == [0.0]
    assert np.abs(shown(data)[0] - rollout.positions[0]).max() < 2.6e-5
    errors = 1e3 * np.linalg.norm(rollout.positions[0] - rollout.extra["target"], axis=1)
    plots = charts(page)
    assert np.nanmax(np.array(plots["map-0"]["data"][0]["z"], dtype=float)) == pytest.approx(errors.max(), rel=0.05)
    assert sum(plots["own-0"]["data"][0]["y"]) == len(errors)


def test_what_the_user_named_is_in_the_command(folder: Path) -> None:
    asked = {"garment": "my <shirt>.obj", "fold": "mine.toml", "size": None, "spacing": 0.012}
    changed(folder / "result.json", lambda r: r.update(asked=asked))
    page = report(folder).read_text()
    assert "tatamu learn &#39;my &lt;shirt&gt;.obj&#39; --out" in page
    assert "--fold mine.toml" in page and "--spacing 0.012" in page and "--size" not in page


def test_a_template_is_filled_in_one_pass(folder: Path) -> None:
    changed(folder / "result.json", lambda r: r["task"].update(garment="{{ version }}"))
    assert "<h1>{{ version }}, half fold</h1>" in report(folder).read_text()
    with pytest.raises(UndefinedError):
        render("report/garment.html")


def test_inline_data_cannot_close_its_script() -> None:
    assert "</" not in inline({"a": "</script><!--"})
    assert json.loads(inline({"a": "</script>\u2028é"})) == {"a": "</script>\u2028é"}
