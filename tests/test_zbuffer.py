"""Triangles to pixels: what a triangle covers, how high it is there, and which of two is seen."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.simulation.mesh.zbuffer import mask, z_buffer

SHAPE = (40, 30)


def triangles(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.uniform([-5, -5, 0], [45, 35, 1], (3 * count, 3)), np.arange(3 * count).reshape(-1, 3)


def test_a_pixel_belongs_to_the_highest_triangle_over_its_centre() -> None:
    """Against a linear solve for every pixel and triangle."""
    points, faces = triangles(12, 3)
    seen = z_buffer(points, faces, SHAPE)
    for i, j in np.ndindex(SHAPE):
        over = []
        for number, face in enumerate(faces):
            corners = points[face]
            weights = np.linalg.solve(np.vstack([corners[:, :2].T, np.ones(3)]), [i + 0.5, j + 0.5, 1.0])
            if (weights >= 0).all():
                over.append((weights @ corners[:, 2], number, weights))
        if not over:
            assert seen.face[i, j] == -1 and seen.heights[i, j] == -np.inf
            continue
        height, number, weights = max(over, key=lambda each: each[0])
        assert seen.face[i, j] == number and seen.heights[i, j] == pytest.approx(height)
        assert seen.weights[i, j] == pytest.approx(weights)


def test_a_mask_is_where_any_triangle_is_seen() -> None:
    points, faces = triangles(8, 5)
    covered = mask(points[:, :2], faces, SHAPE)
    assert 0 < covered.sum() < covered.size
    assert (covered == (z_buffer(points, faces, SHAPE).face >= 0)).all()
    assert (covered == mask(points[:, :2], faces[:, ::-1], SHAPE)).all(), "whichever way the triangle goes round"


def test_slack_takes_in_centres_just_outside() -> None:
    points = np.array([[0.5 + 1e-8, 0.0, 1.0], [10.0, 0.0, 1.0], [0.5 + 1e-8, 10.0, 1.0]])
    faces = np.array([[0, 1, 2]])
    assert (z_buffer(points, faces, SHAPE).face[0] == -1).all()
    assert (z_buffer(points, faces, SHAPE, 1e-6).face[0, :9] == 0).all()


@pytest.mark.parametrize("corner", [[1.0, 1.0, 0.0], [np.nan, 5.0, 0.0], [np.inf, 5.0, 0.0]])
def test_a_triangle_without_an_area_is_not_seen(corner: list[float]) -> None:
    points = np.array([[0.0, 0.0, 0.0], [20.0, 20.0, 0.0], corner])
    assert (z_buffer(points, np.array([[0, 1, 2]]), SHAPE).face == -1).all()
