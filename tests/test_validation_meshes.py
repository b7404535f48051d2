from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tatamu.simulation.mesh.crossings import crossings, crossings_over_time
from tatamu.simulation.mesh.topology import Topology, areas, check_mesh
from tests.physics.meshes import LAYOUTS, Mesh, irregular, mirrored, right
from tests.physics.scenes import joined, raised, vertex_areas

NO_SEAMS = np.empty((0, 2), dtype=np.int64)


def signed(mesh: Mesh) -> np.ndarray:
    a, b, c = (mesh[0][mesh[1][:, k]] for k in range(3))
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


@pytest.mark.parametrize("spacing", [0.02, 0.01, 0.005])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_layout_covers_the_rectangle_once(layout: str, spacing: float) -> None:
    mesh = LAYOUTS[layout](0.1, 0.06, spacing)
    check_mesh(raised(mesh[0]), mesh[1], NO_SEAMS)
    assert (signed(mesh) > 0).all()
    assert_allclose(signed(mesh).sum(), 0.006)
    border = mesh[0][Topology(mesh[1]).border]
    assert_allclose(np.linalg.norm(border[:, 0] - border[:, 1], axis=1).sum(), 0.32)
    for end in (0.0, 0.1):
        assert (mesh[0][:, 0] == end).sum() >= 4


@pytest.mark.parametrize("layout", LAYOUTS)
def test_mirrored_mesh_is_one_symmetric_piece(layout: str) -> None:
    half = LAYOUTS[layout](0.1, 0.06, 0.01)
    points, faces = mirrored(half)
    check_mesh(raised(points), faces, NO_SEAMS)
    assert (signed((points, faces)) > 0).all()
    assert_allclose(signed((points, faces)).sum(), 0.012)
    there, back = (np.array(sorted(map(tuple, np.round(p, 9) + 0.0))) for p in (points, points * [-1, 1]))
    assert_allclose(there, back, atol=1e-12)


def test_flat_and_rolled_cloth_do_not_cross() -> None:
    plan, faces = right(0.2, 0.1, 0.01)
    assert crossings(raised(plan), faces) == 0
    rolled = np.column_stack([0.02 * np.cos(plan[:, 0] / 0.02), plan[:, 1], 0.02 * np.sin(plan[:, 0] / 0.02)])
    spiral = rolled * (1 + 2 * plan[:, :1])
    assert crossings(spiral, faces) == 0


def test_a_poked_sheet_crosses() -> None:
    lower, upper = right(0.1, 0.1, 0.02), irregular(0.1, 0.1, 0.02)
    vertices, faces, members = joined([(raised(lower[0]), lower[1]), (raised(upper[0], 0.005), upper[1])])
    assert crossings(vertices, faces) == 0
    middle = members[1][np.argmin(np.linalg.norm(upper[0] - 0.053, axis=1))]
    vertices[middle, 2] = -0.005
    assert crossings(vertices, faces) > 3
    assert crossings_over_time(np.stack([vertices, vertices + 0.1]), faces).min() > 3


def test_crossings_agree_with_trying_all_pairs() -> None:
    random = np.random.default_rng(0)
    points = random.normal(size=(40, 3)) * [0.3, 1.0, 0.1]
    faces = np.array([random.choice(40, 3, replace=False) for _ in range(40)])
    edges = Topology(faces).edges
    assert crossings(points, faces) == sum(pierces(points, edge, face) for edge in edges for face in faces)


def pierces(points: np.ndarray, edge: np.ndarray, face: np.ndarray) -> bool:
    if set(edge) & set(face):
        return False
    (p, q), (a, b, c) = points[edge], points[face]
    s, u, v = np.linalg.solve(np.column_stack([q - p, a - b, a - c]), a - p)
    return bool(0 < s < 1 and u > 0 and v > 0 and u + v < 1)


def test_positions_that_are_not_finite_count_as_crossings() -> None:
    plan, faces = right(0.1, 0.1, 0.02)
    points = raised(plan)
    points[0, 0] = np.nan
    assert crossings(points, faces) > 0
    assert areas(raised(plan), faces).min() > 0


def test_vertex_areas_share_out_the_whole_area() -> None:
    plan, faces = irregular(0.1, 0.06, 0.01)
    assert_allclose(vertex_areas(raised(plan), faces).sum(), 0.006)
