"""Targets, creases, trajectories, scores."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu import InputError
from tatamu.base import curves
from tatamu.folding.baselines import BASELINES, li_2015
from tatamu.folding.fold import Fold, make_fold
from tatamu.folding.manipulation import TOP_SPEED, bezier_manipulation
from tatamu.folding.score import score, shape_distance, top_views
from tatamu.folding.trial_scene import scene_of
from tatamu.garments import make_garment
from tatamu.simulation.heavy_strip import crease


@pytest.fixture(scope="module")
def fold() -> Fold:
    return make_fold("half", make_garment("towel", spacing=0.02))


def test_the_crease_is_as_long_as_the_cloth_it_is_made_of_and_flush() -> None:
    profile = crease(0.026, 0.002)
    made = np.hypot(np.diff(profile.x), np.diff(profile.z)).sum()
    assert made == pytest.approx(profile.arc[-1] - profile.arc[0], rel=1e-6)
    assert profile.x[0] == pytest.approx(profile.x[-1], abs=1e-9)
    assert (profile.z[0], profile.z[-1]) == pytest.approx((0.003, 0.001), abs=1e-7)


def test_the_crease_of_a_heavy_strip_is_about_a_bending_length_high() -> None:
    """Heights of a chain of 0.5 mm links, measured apart from this code: 33.8 mm for 3.7 cm, 20.2 mm for 2.2 cm."""
    assert crease(0.037, 0.0005).z.max() == pytest.approx(0.0338, rel=0.01)
    assert crease(0.022, 0.0005).z.max() == pytest.approx(0.0202, rel=0.01)


def test_the_crease_is_a_minimum_of_energy() -> None:
    """Of all creases that are flush the cloth's own has the least energy; stiffer and limper cloth's have more."""
    own, stiffer, limper = (_energy(bending_length) for bending_length in (0.026, 0.027, 0.025))
    assert own < min(stiffer, limper)


def _energy(bending_length: float) -> float:
    """What cloth of 26 mm bending length has in the crease of another's, and in what lies flat beside it [w m^2]."""
    profile = crease(bending_length, 0.002)
    step = profile.arc[1] - profile.arc[0]
    bend = np.diff(np.unwrap(np.arctan2(np.diff(profile.z), np.diff(profile.x))))
    over = profile.z - np.where(profile.arc > 0, 0.001, 0.003)
    return float((bend**2).sum() / step * 0.026**3 / 2 + over.sum() * step)


def test_the_target_is_flush_and_layered(fold: Fold) -> None:
    garment, target = fold.garment, fold.target
    far = garment.vertices[:, 0] < -0.2
    assert target[far, 0] == pytest.approx(-garment.vertices[far, 0], abs=1e-12)
    assert target[far, 2] == pytest.approx(1.5 * garment.material.thickness, abs=1e-6)
    assert (target[:, 1] == garment.vertices[:, 1]).all()
    stays = garment.vertices[:, 0] > 0.2
    assert target[stays] == pytest.approx(garment.vertices[stays], abs=1e-6)
    edges = np.linalg.norm(np.diff(target[fold.garment.faces[:, [0, 1]]], axis=1), axis=-1)
    flat = np.linalg.norm(np.diff(garment.vertices[fold.garment.faces[:, [0, 1]]], axis=1), axis=-1)
    assert (edges / flat).min() > 0.85  # chords of the crease are shorter than its arc, nothing is longer
    assert (edges / flat).max() < 1.0 + 1e-6


def test_grasps_of_the_two_hands_keep_apart(fold: Fold) -> None:
    y = fold.garment.vertices[:, 1]
    assert y[fold.left].min() - y[fold.right].max() >= 0.06 - 1e-9
    assert len(fold.left) == len(fold.right) == fold.candidates >= 5
    assert (np.diff(y[fold.left]) < 0).all()
    assert (np.diff(y[fold.right]) > 0).all()


def test_a_bezier_starts_at_p0_ends_at_p3_and_meets_bernstein() -> None:
    points = np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 2.0], [4.0, 0.0]])
    curve = curves.bezier(points, np.array([0.0, 0.5, 1.0]))
    assert curve[0] == pytest.approx(points[0])
    assert curve[2] == pytest.approx(points[3])
    assert curve[1] == pytest.approx((points[0] + 3 * points[1] + 3 * points[2] + points[3]) / 8)


def test_hands_never_move_faster_than_the_top_speed(fold: Fold) -> None:
    for _, make in BASELINES.values():
        times, displacements = make(fold).motion()
        for moved in displacements:
            speed = np.linalg.norm(np.diff(moved, axis=0), axis=1) / np.diff(times)
            assert speed.max() <= TOP_SPEED * (1 + 1e-6)
            assert speed.max() > 0.95 * TOP_SPEED
            assert moved[-1] == pytest.approx([0.8, 0.0, 0.002])


def test_the_curve_of_li_2015_has_its_published_height(fold: Fold) -> None:
    displacement = li_2015(fold).paths[0]
    assert displacement[:, 2].max() / fold.span == pytest.approx(0.2578, abs=2e-3)
    assert curves.length(displacement) / fold.span == pytest.approx(1.1688, abs=2e-3)


def test_a_pinch_holds_more_than_one_vertex_and_never_both_hands_the_same(fold: Fold) -> None:
    for left, right in zip(fold.left, fold.right, strict=True):
        held = fold.patch(int(left)), fold.patch(int(right))
        assert min(map(len, held)) >= 2
        assert not set(held[0]) & set(held[1])


def test_the_scene_of_a_manipulation_is_the_manipulation(fold: Fold) -> None:
    manipulation = bezier_manipulation(fold, (int(fold.left[0]), int(fold.right[1])), 0.2, 0.2, 0.5, 0.3)
    scene, words = scene_of(fold, manipulation), manipulation.describe().model_dump()
    for gripper, arm in zip(scene.grippers, words["arms"], strict=True):
        assert gripper.vertices == arm["grasp"]["patch"]
        start = np.array(arm["grasp"]["position"])
        for time, point in zip(words["via_points"]["times"], words["via_points"][arm["name"]], strict=True):
            assert start + gripper.displacement(time) == pytest.approx(point, abs=1e-9)
    steps = np.diff(words["via_points"]["times"])
    assert steps[:-1] == pytest.approx(10 / 60)
    assert words["arms"][0]["control_points"][3] == pytest.approx(
        np.array(words["arms"][0]["control_points"][0]) + np.array([0.8, 0.0, 0.002])
    )


def test_a_perfect_fold_scores_nothing_but_its_length(fold: Fold) -> None:
    perfect = score(fold, 1.0, fold.target)
    assert perfect.objective == 1.0
    assert perfect.mean_vertex_distance == perfect.slip == perfect.residual_bend == 0.0
    assert perfect.mask_iou == 1.0
    assert perfect.area_error < 2.77


def test_the_objective_is_the_papers() -> None:
    e = np.array([0.0, 0.0, 0.0, 0.1])
    mean, deviation = 0.025, np.sqrt(3) * 0.025
    assert shape_distance(e) == pytest.approx(0.1 * (1 + 0.1 - (mean + 1.28 * deviation)))


def test_a_shifted_fold_is_seen_in_every_measure(fold: Fold) -> None:
    shifted = score(fold, 1.0, fold.target + np.array([0.01, 0.0, 0.0]))
    assert shifted.mean_vertex_distance == pytest.approx(0.01)
    assert shifted.slip == pytest.approx(0.01)
    width = 0.4 - fold.target[:, 0].min()
    assert shifted.mask_iou == pytest.approx((width - 0.01) / (width + 0.01), abs=0.01)


def test_an_untouched_towel_has_an_area_error_of_100_percent(fold: Fold) -> None:
    assert score(fold, 0.0, fold.garment.vertices).area_error == pytest.approx(100.0)


def test_a_mask_has_the_area_of_its_shape() -> None:
    square = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0.0, 0.1, 0]])
    (mask,) = top_views(np.array([[0, 1, 2], [0, 2, 3]]), square)
    assert mask.sum() == 100 * 100


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"size": (0.0, 0.8)}, "width"),
        ({"size": (0.3, -1.0)}, "length"),
        ({"size": (0.3, float("nan"))}, "length"),
        ({"size": (50.0, 0.8)}, "width"),
        ({"spacing": 0.0}, "spacing"),
        ({"spacing": 0.2}, "spacing"),
    ],
)
def test_a_towel_that_cannot_be_is_refused(arguments: dict[str, tuple[float, float]], named: str) -> None:
    with pytest.raises(InputError, match=named):
        make_garment("towel", **arguments)  # type: ignore[arg-type]


def test_an_unknown_fold_is_refused_with_the_known_ones() -> None:
    with pytest.raises(InputError, match="one of half"):
        make_fold("origami", make_garment("towel", spacing=0.05))


def test_a_towel_too_short_for_its_crease_is_refused() -> None:
    with pytest.raises(InputError, match="crease"):
        make_fold("half", make_garment("towel", size=(0.2, 0.2)))
