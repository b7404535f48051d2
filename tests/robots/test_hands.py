import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.folding.fold import make_fold
from tatamu.folding.manipulation import bezier_manipulation
from tatamu.garments import make_garment
from tatamu.robots.hands import HandMotion
from tests.refusals import refusal
from tests.robots.folds import bezier, folder, manipulation


def write(path: Path, value: Any) -> Path:
    path.mkdir(exist_ok=True)
    (path / "manipulation.json").write_text(json.dumps(value))
    return path


def test_hands_pass_every_via_point_at_its_time(tmp_path: Path) -> None:
    fold = manipulation()
    hands = HandMotion.load(folder(tmp_path))
    via = fold["via_points"]
    found = hands.at(np.array(via["times"]))
    assert np.abs(found[0] - via["left"]).max() < 2e-4
    assert np.abs(found[1] - via["right"]).max() < 2e-4


def test_hands_never_leave_their_curve(tmp_path: Path) -> None:
    hands = HandMotion.load(folder(tmp_path))
    curve = bezier(np.array(manipulation()["arms"][0]["control_points"]), np.linspace(0, 1, 5000))
    points = hands.at(np.linspace(0, 4, 200))[0]
    assert max(np.linalg.norm(curve - point, axis=1).min() for point in points) < 2e-4


def test_hands_are_at_rest_before_and_after(tmp_path: Path) -> None:
    hands = HandMotion.load(folder(tmp_path))
    for time in (hands.times[0], hands.times[-1] - 1e-3):
        step = hands.at(np.array([time, time + 1e-3]))
        assert np.abs(np.diff(step, axis=1)).max() < 1e-5


def test_a_curve_that_turns_back_is_followed_in_order(tmp_path: Path) -> None:
    fold = manipulation()
    del fold["via_points"]
    for arm in fold["arms"]:
        p0 = np.array(arm["control_points"][0])
        control = p0 + np.array([[0, 0, 0], [0.5, 0, 0.2], [-0.3, 0, 0.25], [0.34, 0, 0.001]])
        arm["control_points"] = control.tolist()
    hands = HandMotion.load(write(tmp_path / "loop", fold))
    curve = bezier(control, np.linspace(0, 1, 5000))
    nearest = [
        int(np.linalg.norm(curve - point, axis=1).argmin())
        for point in hands.at(np.linspace(hands.times[0], hands.times[-1], 100))[1]
    ]
    assert nearest[0] == 0 and nearest[-1] == 4999 and (np.diff(nearest) >= 0).all()


def test_the_motion_of_the_file_is_that_of_the_manipulation_to_the_last_bit(tmp_path: Path) -> None:
    fold = make_fold("half", make_garment("towel", (0.30, 0.36), None, 0.03))
    made = bezier_manipulation(fold, (int(fold.left[0]), int(fold.right[0])), 0.05, 0.1, 0.25, 0.15)
    exact = HandMotion.exact(made)
    made.save(tmp_path / "manipulation.json")
    times = np.linspace(exact.times[0], exact.times[-1], 200)
    assert (HandMotion.load(tmp_path).at(times) == exact.at(times)).all()
    knots, displacements = made.motion()
    for place, moved, points in zip(made.positions, displacements, exact.at(knots), strict=True):
        assert np.abs(place + moved - points).max() < 1e-5


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda fold: fold["via_points"]["left"].pop(), "via_points"),
        (lambda fold: fold["via_points"]["left"][5].__setitem__(2, 0.9), "via_points.left"),
        (lambda fold: fold["arms"].clear(), "arms"),
        (lambda fold: fold["arms"][0].update(name="right"), "arms"),
        (lambda fold: fold["arms"][0]["control_points"].pop(), "control_points"),
        (lambda fold: fold["timing"].update(arrives=0.0), "timing"),
        (lambda fold: fold.update(frame_rate=0), "frame_rate"),
        (lambda fold: fold.update(version=2), "version"),
    ],
)
def test_a_wrong_field_is_named(tmp_path: Path, change: Any, field: str) -> None:
    fold = manipulation()
    change(fold)
    said = refusal(HandMotion.load, write(tmp_path / "fold", fold))
    assert re.search(field, said) and "manipulation.json" in said


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere"):
        HandMotion.load(tmp_path / "nowhere")


def test_a_folder_of_something_else_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must be the folder of a learned fold, but has no manipulation.json"):
        HandMotion.load(tmp_path)


def test_a_plan_of_several_steps_is_refused_and_its_steps_are_named(tmp_path: Path) -> None:
    for step in ("step-1", "step-2", "step-10"):
        folder(tmp_path / "shop" / step)
    (tmp_path / "shop" / "step-11").mkdir()  # not learned yet
    with pytest.raises(
        InputError, match=r"plan of several steps; give the folder of one step: \S*shop/step-1, \S*step-2, \S*step-10$"
    ):
        HandMotion.load(tmp_path / "shop")
    assert HandMotion.load(tmp_path / "shop" / "step-1")
