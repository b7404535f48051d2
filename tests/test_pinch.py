"""Fingers press the layers between them together, and lay them on one another in the order they were in."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu import Scene, simulate
from tatamu.evaluation.nominal import Nominal
from tatamu.folding.fold import fold_of, ideal_folds
from tatamu.folding.grasps import APART, outermost, pressed
from tatamu.folding.manipulation import WAIT, Manipulation, bezier_manipulation
from tatamu.folding.plans import make_plan
from tatamu.folding.task import make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.garments import make_garment

T, CELL = 0.001, 0.012


def rows(across: list[float], along: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Every place across with every place along [m]."""
    return tuple(grid.ravel() for grid in np.meshgrid(across, along, indexing="ij"))  # type: ignore[return-value]


def chain(*vertices: int) -> np.ndarray:
    """Edges that join vertices one to the next."""
    return np.column_stack([vertices[:-1], vertices[1:]])


def test_of_a_layer_its_outermost_row_is_held() -> None:
    across, along = rows([0.0, 0.9 * CELL], [0.0, CELL, 2 * CELL])
    assert outermost(across, along, chain(*range(6)), CELL).tolist() == [True] * 3 + [False] * 3


def test_every_layer_is_held_by_its_own_outermost_row() -> None:
    across, along = rows([0.0, 0.9 * CELL], [0.0, CELL])
    links = np.concatenate([chain(0, 1), chain(2, 3)])  # two layers, the edge of one of them farther in
    assert outermost(across, along, links, CELL).all()


def test_a_slanting_edge_is_held_whole_and_a_shifted_row_behind_it_is_not() -> None:
    along = np.array([0.0, CELL, 2 * CELL, 0.5 * CELL, 1.5 * CELL])
    across = np.array([0.0, 0.4 * CELL, 0.8 * CELL, 1.1 * CELL, 1.5 * CELL])
    assert outermost(across, along, chain(0, 1, 2, 3, 4), CELL).tolist() == [True] * 3 + [False] * 2


@pytest.mark.parametrize("spacing", [0.02, 0.01, 0.005])
def test_on_any_mesh_a_hand_holds_the_hem_and_nothing_behind_it(spacing: float) -> None:
    towel = make_garment("towel", (0.12, 0.3), None, spacing)
    plan = make_plan("half", towel)
    fold = fold_of(towel, plan, plan.steps[0])
    for vertex in {*fold.left.tolist(), *fold.right.tolist()}:
        held = towel.vertices[fold.patch(vertex)]
        assert len(held) >= 2 and (held[:, 0] == towel.vertices[vertex, 0]).all()


def test_half_the_mesh_makes_the_same_fold() -> None:
    curve = {"x1": 0.05, "z1": 0.25, "x2": 0.40, "z2": 0.30, "g1": 0.0, "g2": 0.0}
    scores = []
    for spacing in (0.02, 0.01):
        task = make_task("towel", size=(0.24, 0.6), spacing=spacing)
        reached = Nominal(task)(curve).score
        assert reached is not None
        scores.append(reached.mean_vertex_distance)
    assert max(scores) < 0.003  # with a second row in the fingers the finer mesh was 8 mm off


def tower(*heights: float) -> np.ndarray:
    """Points over one another."""
    return np.array([[0.0, 0.0, height] for height in heights])


def test_layers_that_lie_on_each_other_stay_as_they_lie() -> None:
    assert (pressed(tower(0.5 * T, 1.5 * T, 2.5 * T), T, CELL) == 0.0).all()


def test_loose_layers_come_to_lie_on_each_other_in_their_order() -> None:
    points = tower(0.025, 0.0005, 0.012, 0.0015)
    after = points[:, 2] + pressed(points, T, CELL)
    assert after == pytest.approx([0.0005 + 3 * APART * T, 0.0005, 0.0005 + 2 * APART * T, 0.0015])


def test_what_is_beside_does_not_carry() -> None:
    points = np.array([[0.0, 0.0, 0.0005], [CELL, 0.0, 0.0105]])
    assert pressed(points, T, CELL)[1] == pytest.approx(-0.01)


def test_nothing_is_pushed_up_or_pressed_by_less_than_a_thickness() -> None:
    points = tower(0.0005, 0.0007, 0.0026, 0.0024)
    assert (pressed(points, T, CELL) == 0.0).all()


def second_fold() -> tuple[Scene, Manipulation, np.ndarray]:
    """A folded towel whose upper layer is lifted 2 cm, about to be folded along its length."""
    towel = make_garment("towel", (0.24, 0.5), None, 0.03)
    plan = make_plan("quarters", towel)
    state = ideal_folds(towel, plan)[0].target.copy()
    state[towel.vertices[:, 0] < 0, 2] += 0.02
    fold = fold_of(towel, plan, plan.steps[1], state)
    manipulation = bezier_manipulation(fold, (int(fold.left[2]), int(fold.right[2])), 0.02, 0.06, 0.1, 0.06)
    return scene_of(fold, manipulation), manipulation, state


def test_a_hand_is_a_gripper_for_each_height_that_its_fingers_press_down() -> None:
    scene, manipulation, state = second_fold()
    assert len(scene.grippers) > 2
    for vertex, moved in zip(manipulation.grasps, manipulation.motion()[1], strict=True):
        hand = [gripper for gripper in scene.grippers if _near(state, gripper.vertices[0], vertex)]
        assert (hand[0].displacements == moved).all(), "the lowest layers go the hand's way and no other"
        closed = np.concatenate([state[g.vertices] + g.displacement(WAIT) for g in hand])
        assert np.ptp(closed[:, 2]) < 0.006, "pressed together"
        for gripper in hand:
            way = gripper.displacement(scene.duration) - gripper.displacement(WAIT)
            assert way == pytest.approx(moved[-1], abs=1e-12), "and carried along together"


def test_pressed_layers_are_simulated() -> None:
    scene, _, _ = second_fold()
    positions = simulate(scene).positions
    first = scene.grippers[1]
    frame = round(WAIT * scene.frame_rate)
    assert positions[frame, first.vertices] == pytest.approx(
        positions[0, first.vertices] + first.displacement(WAIT), abs=1e-9
    )


def _near(state: np.ndarray, one: int, other: int) -> bool:
    return bool(np.linalg.norm(state[one, :2] - state[other, :2]) < 0.05)
