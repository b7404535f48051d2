"""Fold plans: lines, stacks of layers and their ideal folds, grasps of all layers, hands at different distances."""

from __future__ import annotations

import re
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from tatamu import InputError
from tatamu.folding.fold import Fold, fold_of, ideal_folds, make_fold
from tatamu.folding.ideal import pressed
from tatamu.folding.manipulation import bezier_manipulation
from tatamu.folding.plan import Plan, line_of, load_plan
from tatamu.folding.plans import PLANS, make_plan
from tatamu.folding.score import score
from tatamu.folding.task import make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.garments import Garment, make_garment
from tatamu.simulation.heavy_strip import crease
from tatamu.simulation.mesh.crossings import crossings
from tatamu.simulation.mesh.topology import Topology
from tatamu.simulation.presets import load_preset
from tatamu.study.record import describe_task
from tests.foreign import GOOD
from tests.refusals import refusal

COARSE = 0.02
EVERY = [(garment, name) for garment, plans in PLANS.items() for name in plans]


@pytest.fixture(scope="module")
def garments() -> dict[str, Garment]:
    return {name: make_garment(name, spacing=COARSE) for name in PLANS}


def first(garment: Garment, name: str, **changes: object) -> Fold:
    plan = make_plan(name, garment)
    return fold_of(garment, plan, plan.steps[0].model_copy(update=changes))


def strain(garment: Garment, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Relative change of every edge's length, and the edges."""
    rest, edges = garment.vertices if garment.rest is None else garment.rest, Topology(garment.faces).edges
    long, short = (np.linalg.norm(x[edges[:, 0]] - x[edges[:, 1]], axis=1) for x in (positions, rest))
    return long / short - 1.0, edges


def test_the_half_fold_of_a_towel_is_the_crease_to_the_last_bit(garments: dict[str, Garment]) -> None:
    towel = garments["towel"]
    x, z = crease(towel.material.bending_length, towel.material.thickness).place(towel.vertices[:, 0])
    assert make_fold("half", towel).target.tobytes() == np.column_stack([x, towel.vertices[:, 1], z]).tobytes()


@pytest.mark.parametrize(("garment", "name"), EVERY)
def test_every_plan_can_be_folded_step_by_step(garment: str, name: str, garments: dict[str, Garment]) -> None:
    made = garments[garment]
    plan, state = make_plan(name, made), made.vertices
    for step in plan.steps:
        fold = fold_of(made, plan, step, state)
        across = fold.crease.split(state)[0]
        assert (across[[*fold.left, *fold.right]] < 0).all()
        assert not set(fold.left) & set(fold.right)
        assert fold.target[:, 2].min() > 0.4 * made.material.thickness
        assert step is not plan.steps[0] or crossings(fold.target, made.faces) == 0
        state = fold.target
    assert (ideal_folds(made, plan)[-1].target == state).all()


@pytest.mark.parametrize("garment", PLANS)
def test_the_plan_of_the_docs_folds_every_garment(garment: str, garments: dict[str, Garment], tmp_path: Path) -> None:
    page = (Path(__file__).parent.parent / "docs" / "reference" / "fold-plan.md").read_text()
    block = page.split("## A plan of your own")[1].split("`line` and `moves`")[0]
    (tmp_path / "corner-in.toml").write_text(dedent(block))
    assert len(ideal_folds(garments[garment], load_plan(tmp_path / "corner-in.toml"))) == 2


@pytest.mark.parametrize(("garment", "name"), [("towel", "half"), ("tshirt", "half"), ("trousers", "leg")])
def test_the_first_fold_mirrors_and_reverses_the_layers(garment: str, name: str, garments: dict[str, Garment]) -> None:
    made, fold = garments[garment], first(garments[garment], name)
    t = made.material.thickness
    across, along = fold.crease.split(made.vertices)
    turned, beside = fold.crease.split(fold.target)
    flat = across < -4.5 * made.material.bending_length
    assert flat.sum() > 20
    assert turned[flat] == pytest.approx(-across[flat], abs=1e-9)
    assert beside == pytest.approx(along, abs=1e-9)
    layers = 1 if garment == "towel" else 2
    covered = flat & (fold.stacks.under > 0.9 * layers * t) & (made.vertices[:, 2] != t)
    assert fold.target[covered, 2] == pytest.approx(2 * layers * t - made.vertices[covered, 2], abs=0.3 * t)
    assert fold.target[across > 4.5 * made.material.bending_length] == pytest.approx(
        made.vertices[across > 4.5 * made.material.bending_length], abs=1e-6
    )


@pytest.mark.parametrize(("garment", "name"), [("tshirt", "half"), ("trousers", "leg")])
def test_layers_of_a_target_neither_cross_nor_stretch(garment: str, name: str, garments: dict[str, Garment]) -> None:
    made, fold = garments[garment], first(garments[garment], name)
    assert crossings(fold.target, made.faces) == 0
    change, edges = strain(made, fold.target)
    assert change.max() < 0.05
    away = np.abs(fold.crease.split(made.vertices)[0])[edges].min(1) > 4.5 * made.material.bending_length
    assert np.abs(change[away]).max() < 0.02


def test_legs_lie_flat_where_no_cloth_crosses_the_line() -> None:
    made = make_garment("trousers", material=load_preset("denim").material, spacing=COARSE)
    fold = first(made, "leg")
    hems = made.vertices[:, 0] < -0.1
    assert fold.target[hems, 2].max() < 4.5 * made.material.thickness
    assert fold.target[~hems, 2].max() > 0.02


def test_layers_keep_their_distance_round_the_crease(garments: dict[str, Garment]) -> None:
    """Front and back of a T-shirt share their mesh: the same place on both is a thickness apart, also in the loop."""
    made = garments["tshirt"]
    fold, t = first(made, "half"), made.material.thickness
    keys = {tuple(xy): v for v, xy in enumerate(made.vertices[:, :2].round(9).tolist()) if made.vertices[v, 2] < t}
    pairs = [
        (v, keys[tuple(xy)])
        for v, xy in enumerate(made.vertices[:, :2].round(9).tolist())
        if made.vertices[v, 2] > t and tuple(xy) in keys
    ]
    front, back = np.array(pairs).T
    assert len(front) > 200
    apart = np.linalg.norm(fold.target[front] - fold.target[back], axis=1)
    assert apart.min() > 0.95 * t
    assert apart.max() < 1.05 * t


def test_the_target_follows_the_achieved_state(garments: dict[str, Garment]) -> None:
    towel = garments["towel"]
    plan = make_plan("quarters", towel)
    state = ideal_folds(towel, plan)[0].target
    moved = state + np.array([0.03, 0.0, 0.0])
    before, after = (fold_of(towel, plan, plan.steps[1], s).target for s in (state, moved))
    assert (after - before).mean(axis=0) == pytest.approx([0.03, 0.0, 0.0], abs=2e-4)
    assert np.abs(after - before - [0.03, 0.0, 0.0]).max() < 3e-3  # heights are read off pixels of a millimetre


def test_a_pinch_takes_both_layers_and_only_those_that_move(garments: dict[str, Garment]) -> None:
    made, fold = garments["tshirt"], first(garments["tshirt"], "half")
    for vertex in [*fold.left, *fold.right]:
        heights = made.vertices[fold.patch(int(vertex)), 2]
        assert heights.min() < 0.6 * made.material.thickness
        assert heights.max() > 1.4 * made.material.thickness
    plan = make_plan("quarters", garments["towel"])
    folded = ideal_folds(garments["towel"], plan)[0].target
    second = fold_of(garments["towel"], plan, plan.steps[1], folded)
    held = second.patch(int(second.left[0]))
    x = garments["towel"].vertices[held, 0]
    assert x.min() < 0 < x.max(), "both layers of the folded towel"
    assert (folded[held, 1] < 0).all()


def test_release_lays_the_lowest_layer_on_what_stays(garments: dict[str, Garment]) -> None:
    made, fold = garments["trousers"], first(garments["trousers"], "leg")
    t = made.material.thickness
    for vertex in fold.left:
        lowest = made.vertices[fold.patch(int(vertex)), 2].min() + fold.translation(int(vertex))[2]
        assert 2.0 * t - 1e-9 < lowest < 2.5 * t + 1e-9, "half a thickness over the seam or over both layers"


def test_hands_at_different_distances_turn_the_cloth_together(garments: dict[str, Garment]) -> None:
    fold = first(garments["tshirt"], "shop")
    left, right = int(fold.left[0]), int(fold.right[0])
    assert fold.span_of(left) > 1.3 * fold.span_of(right)
    manipulation = bezier_manipulation(fold, (left, right), 0.3 * fold.span, 0.4 * fold.span, 0.05, 0.2)
    for vertex, hand in zip((left, right), manipulation.hands, strict=True):
        points = hand.control_points
        assert points is not None
        mirrored = fold.crease.mirrored(fold.start[[vertex], :2])[0]
        assert fold.start[vertex, :2] + points[3, :2] == pytest.approx(mirrored, abs=1e-12)
        assert np.linalg.norm(points[1]) / fold.span_of(vertex) == pytest.approx(0.5)
        assert points[1][:2] @ fold.crease.along == pytest.approx(0.0, abs=1e-12)
    words = manipulation.describe().model_dump()
    assert words["via_points"]["left"][-1] != words["via_points"]["right"][-1]


def test_an_oblique_line_folds_a_corner(garments: dict[str, Garment]) -> None:
    towel = garments["towel"]
    plan = Plan.model_validate(
        {"name": "corner", "unit": "m", "step": [{"line": [[-0.1, -0.3], [0.3, 0.1]], "moves": "-y", "hands": 1}]}
    )
    fold = fold_of(towel, plan, plan.steps[0])
    assert fold.normal == pytest.approx([-np.sqrt(0.5), np.sqrt(0.5)])
    far = fold.crease.split(towel.vertices)[0].argmin()
    assert fold.target[far, :2] == pytest.approx(fold.crease.mirrored(towel.vertices[[far], :2])[0])
    change, _ = strain(towel, fold.target)
    assert change.max() < 0.05, "the corner hangs over the edge of what stays"


def test_one_hand_is_one_gripper(garments: dict[str, Garment]) -> None:
    task = make_task("trousers", fold="leg", hands=1, spacing=COARSE)
    parameters = {"x1": 0.1, "z1": 0.1, "x2": 0.2, "z2": 0.1, "g1": 3, "g2": 0}
    manipulation = task.manipulation(parameters)
    assert manipulation.grasps == (task.fold.left[3],)
    assert len(scene_of(task.fold, manipulation).grippers) == 1
    assert [arm.name for arm in manipulation.describe().arms] == ["left"]
    assert describe_task(task).hands == 1


def test_a_later_step_starts_where_the_cloth_lies_and_knows_its_flat_shape(garments: dict[str, Garment]) -> None:
    towel = garments["towel"]
    plan = make_plan("quarters", towel)
    state = ideal_folds(towel, plan)[0].target
    fold = fold_of(towel, plan, plan.steps[1], state)
    scene = scene_of(fold, bezier_manipulation(fold, (int(fold.left[0]), int(fold.right[0])), 0.1, 0.1, 0.2, 0.1))
    assert (scene.cloth.vertices == state).all()
    assert scene.cloth.rest_vertices is not None
    assert (scene.cloth.rest_vertices == towel.vertices).all()


def test_a_perfect_step_scores_nothing_but_its_length(garments: dict[str, Garment]) -> None:
    fold = first(garments["tshirt"], "shop")
    perfect = score(fold, 1.0, fold.target)
    assert perfect.objective == 1.0
    assert perfect.mask_iou == 1.0
    assert perfect.area_error == 0.0
    assert score(fold, 1.0, fold.start).area_error > 10.0


OWN = """
[plan]
unit = "m"

[[step]]
title = "corner in"
line = [[-0.4, 0.1], [-0.3, 0.2]]
moves = "+y"
grasp = ["left", "bottom"]

[[step]]
line = [[0.0, 0.0], [0.0, 1.0]]
moves = "-x"
"""


def test_a_plan_of_ones_own_is_read(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(OWN)
    plan = load_plan(tmp_path / "mine.toml")
    assert plan.name == "mine"
    assert [step.moves for step in plan.steps] == ["+y", "-x"]
    assert plan.steps[0].grasp == ("left", "bottom")
    assert plan.steps[1].grasp == ("auto",)
    towel = make_garment("towel", spacing=0.04)
    assert (plan.points(plan.steps[0], towel) == [[-0.4, 0.1], [-0.3, 0.2]]).all()


def test_fractions_are_of_length_and_width() -> None:
    towel = make_garment("towel", size=(0.3, 0.8), spacing=0.04)
    plan = Plan.model_validate({"name": "p", "step": [{"line": [[-0.25, 0.5], [0.5, -0.5]], "moves": "-x"}]})
    assert plan.points(plan.steps[0], towel) == pytest.approx(np.array([[-0.2, 0.15], [0.4, -0.15]]))


def test_the_normal_points_away_from_the_side_that_moves() -> None:
    for moves, normal in {"+x": (-1, 0), "-x": (1, 0)}.items():
        assert line_of(np.array([[0.1, -1.0], [0.1, 1.0]]), moves).normal == pytest.approx(normal)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ((' moves = "-x"', ' moves = "left"'), "step.1.moves"),
        (("[[0.0, 0.0], [0.0, 1.0]]", "[[0.0, 0.0], [0.0, 0.0]]"), "two different points"),
        (
            ("[[0.0, 0.0], [0.0, 1.0]]", "[[0.0, 0.0], [1.0, 0.0]]"),
            "moves must point across the fold line, given -x for a line along x",
        ),
        (("[[0.0, 0.0], [0.0, 1.0]]", "[[0.0, nan], [0.0, 1.0]]"), "step.1.line"),
        (('unit = "m"', 'unit = "inch"'), "unit"),
        (('title = "corner in"', 'titel = "corner in"'), "step.0.titel"),
        (("[plan]", "[plan"), "not valid TOML"),
        (('unit = "m"', 'name = ""'), "name"),
    ],
)
def test_a_wrong_plan_names_file_and_field(tmp_path: Path, change: tuple[str, str], says: str) -> None:
    text = OWN.replace(change[0].strip(), change[1].strip())
    assert text != OWN
    (tmp_path / "mine.toml").write_text(text)
    said = refusal(load_plan, tmp_path / "mine.toml")
    assert re.search(says, said) and "mine.toml" in said


@pytest.mark.parametrize(
    ("step", "says"),
    [
        ({"line": [[5, 0], [5, 1]], "moves": "-x"}, "must cross"),
        ({"line": [[0, 0], [0, 1]], "moves": "-x", "grasp": "sleeve"}, "one of bottom, right, top, left or auto"),
        ({"line": [[0, 0], [0, 1]], "moves": "-x", "grasp": "top"}, "moving side"),
        ({"line": [[-0.45, 0], [-0.45, 1]], "moves": "-x"}, "crease"),
    ],
)
def test_a_fold_that_cannot_be_is_refused(step: dict[str, object], says: str, garments: dict[str, Garment]) -> None:
    plan = Plan.model_validate({"name": "p", "step": [step]})
    with pytest.raises(InputError, match=says):
        fold_of(garments["towel"], plan, plan.steps[0])


def test_a_plan_of_another_garment_is_refused_with_the_known_ones(garments: dict[str, Garment]) -> None:
    with pytest.raises(InputError, match=r"one of half, shop or a \.toml file, given 'quarters'"):
        make_plan("quarters", garments["tshirt"])


def test_a_file_named_as_a_garment_of_ours_is_folded_as_any_other(tmp_path: Path) -> None:
    shirt = make_garment(str(GOOD["tshirt_svg"](tmp_path).rename(tmp_path / "tshirt.svg")), spacing=0.03)
    assert shirt.name == "tshirt"
    assert make_plan("half", shirt).steps[0].title == "in half across the length"
    with pytest.raises(InputError, match="must be one of half"):
        make_plan("shop", shirt)


def test_loops_of_a_narrow_package_are_pressed_from_their_whole_height(garments: dict[str, Garment]) -> None:
    """The loops of both sides are so wide that most of the package has no flat part."""
    shirt = garments["tshirt"]
    fold = ideal_folds(shirt, make_plan("shop", shirt))[2]
    highest, flat = fold.start[:, 2].max(), 4 * shirt.material.thickness
    assert fold.stacks.middle.max() == pytest.approx(0.5 * (flat + highest))


def test_pressing_keeps_the_order_of_layers() -> None:
    z = np.linspace(0.0, 0.05, 200)
    lower = pressed(z, 0.004)
    assert (np.diff(lower) > 0).all()
    assert (lower[z <= 0.004] == z[z <= 0.004]).all()
    assert lower[-1] < 0.03
