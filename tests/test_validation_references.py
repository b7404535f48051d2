"""Closed-form references against limits and values computed apart from them."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from tatamu.material import Material
from tatamu.validation import plate, references


def test_catenary_has_the_span_and_the_length() -> None:
    curve = references.catenary(0.4, 0.5, 4001)
    assert_allclose(curve[-1, 0] - curve[0, 0], 0.4, rtol=1e-9)
    assert_allclose(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum(), 0.5, rtol=1e-6)
    assert_allclose(curve[[0, -1], 1], 0.0, atol=1e-12)


def test_hanging_sheet_has_the_mean_strain_and_no_strain_at_its_end() -> None:
    fabric = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5)
    s = np.linspace(0, 0.3, 301)
    u = references.hang_displacement(s, 0.3, fabric, 9.81)
    assert_allclose(u[-1] / 0.3, 0.2 * 9.81 * 0.3 / 200.0)
    assert_allclose((u[1] - u[0]) / 1e-3, 0.2 * 9.81 * 0.3 / 100.0, rtol=2e-3)
    assert u[-1] - u[-2] < 1e-3 * u[-1]


def test_incline_sticks_below_and_slides_above_its_threshold() -> None:
    threshold = references.incline_threshold(0.5)
    assert references.incline_acceleration(threshold - 1e-6, 0.5, 9.81) == 0.0
    assert references.incline_acceleration(threshold + 1e-3, 0.5, 9.81) > 0.0
    assert_allclose(references.incline_acceleration(np.pi / 2, 0.5, 9.81), 9.81)


def test_a_pushed_mass_goes_as_far_as_its_equation_of_motion_says() -> None:
    for linear, quadratic in ((0.3, 0.9), (0.4, 0.0), (0.0, 1.2)):
        pushed = plate.Pushed(mass=0.28, force=1.9, linear=linear, quadratic=quadratic)
        speed = distance = 0.0
        step = 1e-5
        for _ in range(60_000):
            speed += step * (1.9 - linear * speed - quadratic * speed**2) / 0.28
            distance += step * speed
        assert_allclose(pushed.distance(0.6), distance, rtol=1e-4)
        assert_allclose(pushed.distance(1e3) - pushed.distance(999.0), pushed.terminal_speed, rtol=1e-6)


def test_a_hanging_plate_swings_with_its_small_period_and_decays_by_its_drag() -> None:
    fabric = Material(
        areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5, air_added_mass=0.08, air_drag_normal=0.1
    )
    times = np.linspace(0, 5, 2001)
    swing = plate.swing_of(times, plate.hanging(fabric, 0.3, 0.01, times, 9.81))
    assert_allclose(swing.period, plate.small_swing_period(fabric, 0.3, 9.81), rtol=2e-3)
    assert_allclose(swing.decrement, 0.1 * swing.period / (2 * 0.28), rtol=1e-3)
    wide = fabric.model_copy(update={"air_drag_normal": 0.0, "air_drag_quadratic": 0.5})
    decay = plate.swing_of(times, 0.3 * plate.hanging(wide, 0.3, 0.05, times, 9.81))
    assert_allclose(decay.decrement[0], 0.5 * decay.excursion[0] / 0.28, rtol=0.02)
