"""T-shirt and trousers: two layers of good triangles, sewn where they should be, that lie still."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.garments import GARMENTS, Garment, make_garment
from tatamu.garments.meshfile import border_loops, faults
from tatamu.garments.outline import Outline
from tatamu.garments.panel import RELAXED, angles, panel
from tatamu.garments.sewing import front_and_back
from tatamu.simulation.mesh.crossings import crossings
from tatamu.simulation.mesh.topology import Topology, areas
from tatamu.simulation.scene import Gripper, Scene, Table
from tatamu.simulation.simulators import simulate

SEWN = ["tshirt", "trousers"]


@cache
def made(name: str) -> Garment:
    """The garment by default."""
    return make_garment(name)


def rest(garment: Garment) -> np.ndarray:
    return garment.vertices if garment.rest is None else garment.rest


def upward(garment: Garment) -> np.ndarray:
    a, b, c = (rest(garment)[garment.faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)[:, 2] > 0


def moves(garment: Garment, seconds: float) -> tuple[float, int]:
    """How far any vertex goes when nobody touches it [m], and crossings in the end."""
    scene = Scene(cloth=garment.cloth(), material=garment.material, table=Table(), duration=seconds)
    positions = simulate(scene).positions
    return float(np.linalg.norm(positions - positions[0], axis=2).max()), crossings(positions[-1], garment.faces)


@pytest.mark.parametrize("name", SEWN)
@pytest.mark.parametrize(("size", "spacing"), [(None, None), ((0.5, 0.5), 0.013), ((0.88, 0.75), 0.02)])
def test_triangles_are_near_equilateral(name: str, size: tuple[float, float] | None, spacing: float | None) -> None:
    garment = make_garment(name, size, spacing=spacing) if size else made(name)
    edges = Topology(garment.faces).edges
    lengths = np.linalg.norm(rest(garment)[edges[:, 0]] - rest(garment)[edges[:, 1]], axis=1)
    assert np.degrees(angles(rest(garment), garment.faces).min()) > 25.0
    assert lengths.min() > 0.45 * garment.spacing
    assert lengths.max() < 1.8 * garment.spacing
    assert np.ptp(garment.vertices[:, :2], axis=0)[::-1] == pytest.approx(size or garment.size)


@pytest.mark.parametrize(("name", "openings"), [("tshirt", 4), ("trousers", 3)])
def test_layers_are_one_surface_with_the_openings_as_its_borders(name: str, openings: int) -> None:
    garment = made(name)
    topology = Topology(garment.faces)
    assert faults(rest(garment) + [0, 0, 1] * garment.vertices, garment.faces) == []
    assert len(border_loops(garment.faces)) == openings
    characteristic = len(garment.vertices) - len(topology.edges) + len(garment.faces)
    assert characteristic == 2 - openings  # a sphere with that many holes
    assert 1000 < len(garment.vertices) <= 3100
    assert garment.layers == 2


@pytest.mark.parametrize("name", SEWN)
def test_front_lies_a_thickness_over_the_back_and_seams_between(name: str) -> None:
    garment = made(name)
    t, up = garment.material.thickness, upward(garment)
    front, back = (np.isin(np.arange(len(garment.vertices)), garment.faces[side]) for side in (up, ~up))
    assert garment.vertices[front & ~back, 2] == pytest.approx(1.5 * t)
    assert garment.vertices[back & ~front, 2] == pytest.approx(0.5 * t)
    assert garment.vertices[front & back, 2] == pytest.approx(t)
    assert set(np.unique(garment.seams)) == set(np.flatnonzero(front & back))
    assert (rest(garment)[:, 2] == 0).all()
    area = areas(rest(garment), garment.faces)
    cut_off = area[~up].sum() - area[up].sum()  # between the necklines
    assert cut_off == pytest.approx(0.0, abs=1e-12) if name == "trousers" else 0.003 < cut_off < 0.006


@pytest.mark.parametrize("name", GARMENTS)
def test_edges_are_paths_of_the_upper_layer_on_the_right_sides(name: str) -> None:
    garment = made(name)
    topology = Topology(garment.faces)
    pairs = {tuple(edge) for edge in topology.edges.tolist()}
    border = {tuple(edge) for edge in topology.border.tolist()}
    for side, path in garment.edges.items():
        steps = [tuple(sorted(step)) for step in pairwise(path.tolist())]
        assert set(steps) <= pairs, side
        assert (set(steps) <= border) == (side in garment.openings), side
        if side.startswith(("left", "right")):
            assert (garment.vertices[path, 1].mean() > 0) == side.startswith("left")
    moving = {"towel": ["bottom"], "tshirt": ["hem"], "trousers": ["left_hem", "right_hem"]}[name]
    for side in moving:
        assert garment.vertices[garment.edges[side], 0] == pytest.approx(garment.vertices[:, 0].min())


@pytest.mark.parametrize("name", SEWN)
def test_a_row_lies_on_the_line_of_a_half_fold(name: str) -> None:
    garment = made(name)
    on_line = np.abs(garment.vertices[:, 0]) < 1e-9
    strips, width = (2, 0.32) if name == "tshirt" else (4, 0.13)
    inside = width / garment.spacing - 2 * RELAXED  # beside the outline, vertices leave their rows
    assert on_line.sum() > 0.9 * strips * inside


def test_vertices_are_numbered_row_by_row() -> None:
    square = np.array([[0, 0], [0.2, 0], [0.2, 0.2], [0, 0.2], [0, 0]])
    x, y = panel(Outline({"around": square}), 0.02).points.T
    row = np.round(x / (0.02 * np.sqrt(0.75)))
    assert (np.diff(row) >= 0).all()  # the simulator lays rows out for speed
    assert (np.diff(y)[np.diff(row) == 0] > 0).all()


@pytest.mark.parametrize("name", SEWN)
def test_garments_lie_still(name: str) -> None:
    motion, crossed = moves(make_garment(name, spacing=0.02), 1.0)
    assert motion < 2e-3
    assert crossed == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", SEWN)
def test_garments_lie_still_on_their_default_mesh(name: str) -> None:
    motion, crossed = moves(made(name), 1.0)
    assert motion < 2e-3
    assert crossed == 0


def test_a_shirt_held_at_both_shoulders_hangs_down() -> None:
    """Fingers at both ends of the neck hold front and back, and lift."""
    shirt = make_garment("tshirt", spacing=0.02)
    grippers = []
    for side in ("left_shoulder", "right_shoulder"):
        corner = shirt.vertices[shirt.edges[side]][:, :2]
        corner = corner[np.argmax(corner[:, 0])]
        held = np.flatnonzero(np.linalg.norm(shirt.vertices[:, :2] - corner, axis=1) < 0.025)
        assert np.ptp(shirt.vertices[held, 2]) == pytest.approx(shirt.material.thickness)  # both layers
        grippers.append(Gripper(vertices=held.tolist(), times=[0.0, 1.5], displacements=[[0, 0, 0], [0, 0, 0.8]]))
    scene = Scene(cloth=shirt.cloth(), material=shirt.material, table=Table(), grippers=grippers, duration=2.0)
    final = simulate(scene).positions[-1]
    edges = Topology(shirt.faces).edges
    ends, flat = final[edges], rest(shirt)[edges]
    stretch = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) / np.linalg.norm(flat[:, 0] - flat[:, 1], axis=1)
    assert stretch.max() < 1.15
    hem = final[shirt.edges["hem"], 2]
    assert final[:, 2].max() - hem.mean() > 0.42  # of 0.46 m
    assert hem.mean() > 0.3


def test_a_large_garment_gets_a_coarser_mesh_unless_asked() -> None:
    shirt = make_garment("tshirt", (0.88, 0.70))
    assert 2500 < len(shirt.vertices) <= 3100
    assert shirt.spacing > shirt.material.bending_length / 2


def test_a_corner_between_two_seams_shares_no_inner_edge() -> None:
    corners = np.array([[-0.1, -0.15], [-0.1, 0.15], [0.1, 0.15], [0.1, -0.15]])
    sides = {name: corners[[(k + 1) % 4, k]] for k, name in enumerate(("bottom", "left", "top", "right"))}
    outline = Outline({name: sides[name] for name in ("right", "top", "left", "bottom")})
    square = front_and_back("pillowcase", outline, ["bottom"], made("tshirt").material, 0.02)
    assert Topology(square.faces).faces_per_edge.max() == 2
    assert np.degrees(angles(rest(square), square.faces).min()) > 25.0


def test_parts_of_an_outline_nearer_than_the_mesh_are_refused() -> None:
    slot = np.array(
        [[0, 0], [0.2, 0], [0.2, 0.0995], [0.02, 0.0999], [0.02, 0.1001], [0.2, 0.1005], [0.2, 0.2], [0, 0.2], [0, 0]]
    )
    with pytest.raises(InputError, match="for a spacing of"):
        panel(Outline({"around": slot}), 0.02)


@pytest.mark.parametrize("name", SEWN)
@pytest.mark.parametrize(
    ("size", "spacing", "words"),
    [((0.01, 0.5), None, "width must be"), ((0.5, 9.0), None, "length must be"), (None, 0.2, "quarter of the shorter")],
)
def test_impossible_sizes_are_refused(
    name: str, size: tuple[float, float] | None, spacing: float | None, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        make_garment(name, size, spacing=spacing)


def test_unknown_garments_are_refused() -> None:
    with pytest.raises(InputError, match="must be one of towel, tshirt, trousers or a file"):
        make_garment("sock")
