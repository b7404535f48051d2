"""The cubic Bezier curve, polylines, minimum jerk."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.base.curves import TOP_SPEED_FACTOR, Bezier, along, arc_lengths, length, minimum_jerk

STRAIGHT = Bezier(np.outer([0.0, 1.0, 2.0, 3.0], [0.1, 0.0, 0.2]))
LOOP = Bezier(np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.2], [-0.3, 0.0, 0.25], [0.34, 0.0, 0.0]]))


def test_a_straight_curve_has_the_length_of_its_chord() -> None:
    u, lengths = STRAIGHT.arc_lengths()
    assert lengths[-1] == pytest.approx(3.0 * np.hypot(0.1, 0.2))
    assert lengths == pytest.approx(u * lengths[-1])


def test_the_nearest_point_is_the_foot_of_the_perpendicular() -> None:
    beside = STRAIGHT.at(np.array([0.3])) + np.array([0.02, 0.0, -0.01])
    u, distance = STRAIGHT.nearest(beside)
    assert u == pytest.approx([0.3], abs=1e-6) and distance == pytest.approx([np.hypot(0.02, 0.01)])


def test_fractions_of_a_polyline_are_of_its_length() -> None:
    corner = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0]])
    assert length(corner) == arc_lengths(corner)[-1] == 4.0
    assert along(corner, np.array([0.5, 0.875])) == pytest.approx(np.array([[2.0, 0.0], [3.0, 0.5]]))


def test_minimum_jerk_rests_at_both_ends_and_is_fastest_in_the_middle() -> None:
    s = np.linspace(-0.2, 1.2, 14001)
    speed = np.gradient(minimum_jerk(s), s)
    assert speed.max() == pytest.approx(TOP_SPEED_FACTOR, rel=1e-4)
    assert s[speed.argmax()] == pytest.approx(0.5, abs=1e-3)
    assert np.abs(speed[(s < 0.001) | (s > 0.999)]).max() < 1e-4
