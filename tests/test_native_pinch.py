"""What a hand does to layers that turn over beside it."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.folding.fold import make_fold
from tatamu.folding.manipulation import Manipulation, scene_of
from tatamu.garments import make_garment
from tatamu.simulators import simulate
from tatamu.simulators.native.pinch import restore_order
from tatamu.topology import Topology
from tatamu.crossings import crossings
from tests.scenes import sheet

THICK = 0.001


def _stack(layers: int, held: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sheets over each other, a little askew, and one vertex of each that a hand holds, in the order upside down."""
    cloth = sheet(0.1, 0.1)
    count = len(cloth.vertices)
    lift = [[0.0002 * layer, 0.0003 * layer, THICK * layer] for layer in range(layers)]
    x = np.concatenate([cloth.vertices + up for up in lift])
    x[held::count, 2] = x[held::count, 2][::-1].copy()
    faces = np.concatenate([cloth.faces + count * layer for layer in range(layers)])
    return x, faces, np.arange(layers) * count + held


@pytest.mark.parametrize("layers", [2, 3, 4])
def test_layers_change_places_when_the_cloth_beside_lies_the_other_way_round(layers: int) -> None:
    x, faces, held = _stack(layers, held=0)
    assert crossings(x, faces) > 0
    assert restore_order(x, held, faces, Topology(faces).edges, THICK)
    assert np.diff(x[held, 2]).min() > 0.5 * THICK
    assert crossings(x, faces) == 0


def test_folded_edges_change_places_too() -> None:
    """Two folded sheets on one another: vertices on their folds have normals that point sideways."""
    cloth = sheet(0.1, 0.1)
    flat, faces = np.tile(cloth.vertices.round(6), (2, 1)), np.concatenate([cloth.faces, cloth.faces + len(cloth.rest)])
    upper, rows = np.arange(len(flat)) >= len(cloth.rest), np.unique(flat[:, 0])
    along, y = flat[:, 0] - rows[len(rows) // 2], flat[:, 1]
    x = np.column_stack([np.abs(along), y, THICK * (0.5 * np.sign(along) + 2.0 * upper)])
    x[upper, :2] += 0.0003
    corner = y < y.min() + 0.006
    ends = np.flatnonzero(corner & (along == 0))
    assert len(ends) == 2
    x[ends, 2] = x[ends[::-1], 2]
    assert crossings(x, faces) > 0
    held = np.flatnonzero(corner & (np.abs(along) < 0.02))
    assert restore_order(x, held, faces, Topology(faces).edges, THICK)
    assert x[ends[1], 2] - x[ends[0], 2] > THICK
    assert crossings(x, faces) == 0


def test_layers_in_order_and_single_ones_stay() -> None:
    x, faces, held = _stack(2, held=0)
    x[held, 2] = x[held, 2][::-1].copy()
    before = x.copy()
    assert not restore_order(x, held, faces, Topology(faces).edges, THICK)
    assert not restore_order(x, np.arange(len(x)), faces, Topology(faces).edges, THICK)
    assert (x == before).all()


def test_a_tshirt_folded_in_half_has_no_layer_through_another() -> None:
    fold = make_fold("half", make_garment("tshirt", (0.4, 0.34), None, 0.016))
    grasps = int(fold.left[2]), int(fold.right[2])
    ways = tuple(np.stack([[0.0, 0.0, 0.0], 0.5 * way + [0.0, 0.0, 0.1], way]) for way in map(fold.translation, grasps))
    scene = scene_of(fold, Manipulation(grasps, ways, None))
    rollout = simulate(scene)
    opens = min(gripper.opens for gripper in scene.grippers if gripper.opens is not None)
    held = rollout.positions[np.searchsorted(rollout.times, opens) - 2]
    assert crossings(held, rollout.faces) > 0  # the hem turned over beside hands that did not
    assert crossings(rollout.positions[-1], rollout.faces) == 0
