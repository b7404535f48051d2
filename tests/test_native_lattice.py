"""Lattices that are found in meshes: rows and columns of vertices, whatever their order."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.mesh.topology import Topology
from tatamu.simulation.native.lattice import MIN_PATCH, Patch, patches
from tests.physics.meshes import LAYOUTS

Mesh = tuple[np.ndarray, np.ndarray]


def turned(mesh: Mesh, degrees: float) -> Mesh:
    """The mesh turned in its plane, with its vertices in no order."""
    vertices, faces = mesh
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    order = np.random.default_rng(3).permutation(len(vertices))
    return (vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))[order], np.argsort(order)[faces]


def beside(one: Mesh, other: Mesh) -> Mesh:
    """Two meshes that share nothing."""
    away = other[0] + np.array([5.0, 0.0, 0.0])
    return np.concatenate([one[0], away]), np.concatenate([one[1], other[1] + len(one[0])])


def found_in(mesh: Mesh) -> list[Patch]:
    return patches(mesh[0], Topology(mesh[1]).hinges)


def steps_along_edges(patch: Patch, faces: np.ndarray) -> np.ndarray:
    """Row and column that each edge within a patch goes on by, upwards or to the right, shape (e, 2)."""
    place = dict(zip(patch.vertices.tolist(), zip(patch.row.tolist(), patch.column.tolist(), strict=True), strict=True))
    edges = [edge for edge in Topology(faces).edges.tolist() if edge[0] in place and edge[1] in place]
    steps = np.array([np.subtract(place[b], place[a]) for a, b in edges])
    back = (steps[:, 0] < 0) | ((steps[:, 0] == 0) & (steps[:, 1] < 0))
    return np.where(back[:, None], -steps, steps)


@pytest.mark.parametrize("degrees", [0.0, 37.0])
def test_all_of_a_staggered_rectangle_is_one_lattice_however_it_lies(degrees: float) -> None:
    mesh = turned(staggered_rectangle(0.2, 0.3, 0.02), degrees)
    (patch,) = found_in(mesh)
    assert sorted(patch.vertices) == list(range(len(mesh[0])))
    assert patch.row.min() == patch.column.min() == 0


def test_neighbours_on_the_mesh_are_neighbours_on_the_lattice() -> None:
    mesh = turned(staggered_rectangle(0.2, 0.3, 0.02), 37.0)
    (patch,) = found_in(mesh)
    steps = steps_along_edges(patch, mesh[1])
    same_row = steps[:, 0] == 0
    assert 0 < same_row.sum() < len(steps)
    assert (steps[same_row, 1] == 1).all()
    assert (steps[~same_row, 0] == 1).all() and (np.abs(steps[~same_row, 1]) <= 1).all()


def test_a_rectangle_needs_a_rectangle_of_places_that_is_well_filled() -> None:
    mesh = turned(staggered_rectangle(0.1, 0.4, 0.02), 12.0)
    (patch,) = found_in(mesh)
    assert (patch.row.max() + 1) * (patch.column.max() + 1) < 1.2 * len(mesh[0])


def test_no_two_vertices_have_one_place_around_a_hole() -> None:
    vertices, faces = staggered_rectangle(0.4, 0.4, 0.02)
    inside = (np.abs(vertices[faces].mean(axis=1)[:, :2]) < 0.08).all(axis=1)
    (patch,) = found_in((vertices, faces[~inside]))
    places = set(zip(patch.row.tolist(), patch.column.tolist(), strict=True))
    assert len(places) == len(patch.vertices) == len(np.unique(faces[~inside]))


def test_no_two_vertices_have_one_place_around_a_vertex_of_seven_triangles() -> None:
    """Seven wedges of a lattice, each with the apex and two sides in common with others: six would fill the plane."""
    number: dict[tuple[float, float], int] = {}
    faces = []
    for wedge in range(7):
        first, second = (np.array([np.cos(a), np.sin(a)]) for a in 2 * np.pi / 7 * np.array([wedge, wedge + 1]))

        def vertex(i: int, j: int, u: np.ndarray = first, w: np.ndarray = second) -> int:
            x, y = (i * u + j * w).round(9) + 0.0
            return number.setdefault((float(x), float(y)), len(number))

        for i in range(6):
            for j in range(6 - i):
                faces.append([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)])
                if i + j < 5:
                    faces.append([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)])
    vertices = np.array([[x, y, 0.0] for x, y in number])
    for patch in found_in((vertices, np.array(faces))):
        assert len(set(zip(patch.row.tolist(), patch.column.tolist(), strict=True))) == len(patch.vertices)


def test_a_vertex_far_from_its_place_is_not_on_the_lattice() -> None:
    vertices, faces = staggered_rectangle(0.2, 0.3, 0.02)
    inner = int(np.argmin(np.linalg.norm(vertices, axis=1)))
    vertices[inner] += [0.0, 0.0, 0.018]
    (patch,) = found_in((vertices, faces))
    assert set(range(len(vertices))) - set(patch.vertices.tolist()) == {inner}


def test_two_panels_are_two_lattices_with_no_vertex_in_common() -> None:
    one, other = staggered_rectangle(0.2, 0.2, 0.02), turned(staggered_rectangle(0.2, 0.3, 0.03), 20.0)
    found = found_in(beside(one, other))
    assert len(found) == 2
    assert sorted(np.concatenate([patch.vertices for patch in found])) == list(range(len(one[0]) + len(other[0])))


def test_where_nothing_repeats_or_little_is_there_is_no_lattice() -> None:
    plan, faces = LAYOUTS["irregular"](0.2, 0.3, 0.02)
    assert sum(len(patch.vertices) for patch in found_in((np.column_stack([plan, 0 * plan[:, 0]]), faces))) < len(plan)
    small = staggered_rectangle(0.06, 0.06, 0.02)
    assert len(small[0]) < MIN_PATCH and found_in(small) == []
