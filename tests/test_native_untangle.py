"""Layers that went through one another in a pinch, and come apart when the hand opens; and those that begin so."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.folding.fold import make_fold
from tatamu.folding.manipulation import polyline_manipulation
from tatamu.folding.trial_scene import scene_of
from tatamu.garments import make_garment
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.crossings import crossing_pairs, crossings
from tatamu.simulation.native import prepare, simulation
from tatamu.simulation.native.contact.state import ContactMesh
from tatamu.simulation.native.contact.untangle import crossing_pairs_after, smallest_height, untangle
from tatamu.simulation.native.model import model_of
from tatamu.simulation.native.options import Options, UntangleOptions
from tatamu.simulation.scene import Cloth, Gripper, Scene
from tatamu.simulation.simulators import simulate
from tests.scenes import sheet

THICK = 0.001
OPTIONS = UntangleOptions()
LIMP = Material(areal_density=0.2, stretch_stiffness=200.0, bending_rigidity=2e-6, thickness=THICK)


def _stack(layers: int, held: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sheets over each other, a little askew, and one vertex of each that a hand holds, in the order upside down."""
    cloth = sheet(0.1, 0.1)
    count = len(cloth.vertices)
    lift = [[0.0002 * layer, 0.0003 * layer, THICK * layer] for layer in range(layers)]
    x = np.concatenate([cloth.vertices + up for up in lift])
    x[held::count, 2] = x[held::count, 2][::-1].copy()
    faces = np.concatenate([cloth.faces + count * layer for layer in range(layers)])
    return x, faces, np.arange(layers) * count + held


def _mesh(rest: np.ndarray, faces: np.ndarray) -> tuple[ContactMesh, np.ndarray]:
    """A mesh as untangling needs it, and the lengths of its edges."""
    model = model_of(Cloth(vertices=rest, faces=faces), LIMP, Options())
    return model.mesh, model.lengths


@pytest.mark.parametrize("layers", [2, 3, 4])
def test_a_vertex_on_the_wrong_side_goes_back(layers: int) -> None:
    x, faces, held = _stack(layers, held=0)
    assert crossings(x, faces) > 0
    apart, left = untangle(x, *_mesh(x, faces), OPTIONS)
    assert left == crossings(apart, faces) == 0
    assert np.linalg.norm(apart[held] - x[held], axis=1).max() < 4 * layers * THICK


@pytest.mark.parametrize("seed", range(5))
def test_pairs_that_a_pass_changed_are_found_among_the_moved_ones(seed: int) -> None:
    random = np.random.default_rng(seed)
    before, faces, _ = _stack(3, held=0)
    before[:, 2] += random.normal(0.0, THICK, len(before))
    mesh, _ = _mesh(_stack(3, held=0)[0], faces)
    pairs = crossing_pairs(before, mesh.faces, mesh.edges)
    x = before.copy()
    some = random.choice(len(x), 20, replace=False)
    x[some, 2] += random.normal(0.0, 2.0 * THICK, len(some))
    found = crossing_pairs_after(x, before, pairs, mesh)
    assert len(pairs) > 0
    assert not np.array_equal(found, pairs)
    assert np.array_equal(found, crossing_pairs(x, mesh.faces, mesh.edges))


def test_folded_edges_come_apart_too() -> None:
    """Two folded sheets on one another, whose folds went through each other in a corner."""
    cloth = sheet(0.1, 0.1)
    flat, faces = np.tile(cloth.vertices.round(6), (2, 1)), np.concatenate([cloth.faces, cloth.faces + len(cloth.rest)])
    upper, rows = np.arange(len(flat)) >= len(cloth.rest), np.unique(flat[:, 0])
    along, y = flat[:, 0] - rows[len(rows) // 2], flat[:, 1]
    x = np.column_stack([np.abs(along), y, THICK * (0.5 * np.sign(along) + 2.0 * upper)])
    x[upper, :2] += 0.0003
    ends = np.flatnonzero((y < y.min() + 0.006) & (along == 0))
    assert len(ends) == 2
    x[ends, 2] = x[ends[::-1], 2]
    assert crossings(x, faces) > 0
    apart, left = untangle(x, *_mesh(flat + [[0.0, 0.0, THICK]] * upper[:, None], faces), OPTIONS)
    assert left == crossings(apart, faces) == 0
    assert apart[ends[1], 2] > apart[ends[0], 2]


def test_what_is_not_tangled_stays_and_edges_keep_their_lengths() -> None:
    x, faces, held = _stack(2, held=0)
    mesh, lengths = _mesh(x, faces)
    apart, _ = untangle(x, mesh, lengths, OPTIONS)
    far = np.linalg.norm(x[:, :2] - x[held[0], :2], axis=1) > 0.05
    assert (apart[far] == x[far]).all()
    now = np.linalg.norm(np.diff(apart[mesh.edges], axis=1)[:, 0], axis=1) / lengths
    assert OPTIONS.shortest - 0.01 < now.min() and now.max() < OPTIONS.longest + 0.01
    again, left = untangle(apart, mesh, lengths, OPTIONS)
    assert again is apart and left == 0


def test_no_triangle_becomes_so_slim_that_bending_would_throw_it() -> None:
    x, faces, _ = _stack(4, held=0)
    mesh, lengths = _mesh(x, faces)
    none_slimmer = UntangleOptions(slimmest=10.0)  # than the slimmest is
    apart, _ = untangle(x, mesh, lengths, none_slimmer)
    assert smallest_height(apart, faces) >= smallest_height(x, faces)
    apart, _ = untangle(x, mesh, lengths, UntangleOptions(slimmest=0.0))
    assert smallest_height(apart, faces) < smallest_height(x, faces)


def test_held_vertices_stay() -> None:
    x, faces, held = _stack(2, held=0)
    mesh, lengths = _mesh(x, faces)
    inverse_mass = mesh.inverse_mass.copy()
    inverse_mass[held] = 0.0
    apart, _ = untangle(x, mesh._replace(inverse_mass=inverse_mass), lengths, OPTIONS)
    assert (apart[held] == x[held]).all()


def test_layers_that_begin_within_one_another_come_apart_before_the_first_step() -> None:
    x, faces, _ = _stack(2, held=10)
    cloth = Cloth(vertices=x + np.array([0.0, 0.0, 0.5]), faces=faces)
    scene = Scene(cloth=cloth, material=LIMP, duration=0.05)
    rollout = simulate(scene, "native")
    assert np.array_equal(rollout.positions[0], cloth.vertices)
    assert crossings(rollout.positions[0], faces) > 0
    assert crossings(rollout.positions[1], faces) == 0


def test_what_stays_tangled_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    tries: list[int] = []
    prepare()  # has a hand that opens, too

    def stuck(
        x: np.ndarray, mesh: ContactMesh, lengths: np.ndarray, options: UntangleOptions
    ) -> tuple[np.ndarray, int]:
        tries.append(1)
        return x, 1 if 1 < len(tries) < 4 else 0  # the first call is before the first step

    monkeypatch.setattr(simulation, "untangle", stuck)
    cloth = sheet(0.1, 0.1)
    hand = Gripper(vertices=[0], times=[0.0], displacements=np.zeros((1, 3)), opens=0.1)
    simulate(Scene(cloth=cloth, material=LIMP, grippers=[hand], duration=0.15))
    assert len(tries) == 2  # the next one would be 0.1 s later
    tries.clear()
    simulate(Scene(cloth=cloth, material=LIMP, grippers=[hand], duration=0.8))
    assert len(tries) == 4


def test_what_came_apart_is_looked_at_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """It may snap back within a few steps: a crumple that had come apart at 0.74 s was tangled at 0.75 s."""
    found: list[bool] = []
    prepare()

    def apart(
        x: np.ndarray, mesh: ContactMesh, lengths: np.ndarray, options: UntangleOptions
    ) -> tuple[np.ndarray, int]:
        found.append(len(found) == 1)  # when the hand opens; the first call is before the first step
        return (x.copy() if found[-1] else x), 0

    monkeypatch.setattr(simulation, "untangle", apart)
    hand = Gripper(vertices=[0], times=[0.0], displacements=np.zeros((1, 3)), opens=0.1)
    simulate(Scene(cloth=sheet(0.1, 0.1), material=LIMP, grippers=[hand], duration=0.8))
    assert found == [False, True, False]


def test_a_tshirt_folded_in_half_has_no_layer_through_another() -> None:
    fold = make_fold("half", make_garment("tshirt", (0.4, 0.34), None, 0.016))
    grasps = int(fold.left[2]), int(fold.right[2])
    ways = tuple(np.stack([[0.0, 0.0, 0.0], 0.5 * way + [0.0, 0.0, 0.1], way]) for way in map(fold.translation, grasps))
    scene = scene_of(fold, polyline_manipulation(fold, grasps, ways))
    rollout = simulate(scene)
    opens = min(gripper.opens for gripper in scene.grippers if gripper.opens is not None)
    held = rollout.positions[np.searchsorted(rollout.times, opens) - 2]
    assert crossings(held, rollout.faces) > 0  # the hem turned over beside hands that did not
    assert crossings(rollout.positions[-1], rollout.faces) == 0
