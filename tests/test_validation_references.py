"""Closed-form references against limits and values computed apart from them."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from tatamu.simulation.heavy_strip import chord
from tatamu.simulation.material import Material
from tatamu.simulation.native.elastic import curvature, membrane
from tests.physics import frictional_strip, plate, references


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
    turning = fabric.model_copy(update={"air_drag_normal": 0.0, "air_drag_turning": 0.2})
    decay = plate.swing_of(times, 0.3 * plate.hanging(turning, 0.3, 0.05, times, 9.81))
    as_much = 4 / (11 / 3) * 27 / 20 * 0.2 * decay.excursion[0] ** (-1 / 3)  # loses as much in a harmonic swing
    assert_allclose(decay.decrement[0], as_much * decay.excursion[0] / 0.28, rtol=0.02)


def test_off_axis_numbers_are_those_of_the_turned_stiffness() -> None:
    woven = Material(
        areal_density=0.2,
        stretch_stiffness=900.0,
        stretch_stiffness_weft=500.0,
        shear_stiffness=40.0,
        poisson_ratio=0.2,
        bending_rigidity=3e-5,
        bending_rigidity_weft=1e-5,
        bending_rigidity_bias=1.5e-5,
    )
    for angle in (0.0, 0.4, np.pi / 4, np.pi / 2):
        c, s = np.cos(angle), np.sin(angle)
        strain = np.array([c * c, s * s, 2 * c * s])  # of a stretch or a curvature along the strip
        stress = np.array([c * c, s * s, c * s])  # of a pull along it
        compliance = stress @ np.linalg.solve(membrane.plane_stress(woven), stress)
        assert_allclose(references.off_axis_stiffness(woven, angle), 1 / compliance)
        bent = strain * [1, 1, 0.5]
        assert_allclose(references.off_axis_rigidity(woven, angle), bent @ curvature.rigidities(woven) @ bent)
    assert_allclose(references.off_axis_rigidity(woven, np.pi / 4), 1.5e-5)


def test_a_strip_without_friction_turns_as_the_heavy_elastica_and_one_with_it_rubs() -> None:
    plain = Material(areal_density=0.2, stretch_stiffness=500.0, bending_rigidity=0.2 * 9.81 * 1e-3 / 10)
    up, level, down = (np.degrees(np.arctan2(*shape[-1, ::-1])) for shape in _turned(plain))
    assert_allclose(level, np.degrees(chord(10.0)), atol=0.01)
    assert_allclose(up, down, atol=1e-6)
    rough = plain.model_copy(update={"bending_hysteresis": 10 * plain.bending_rigidity})
    stiff_up, stiff_level, limp_down = (np.degrees(np.arctan2(*shape[-1, ::-1])) for shape in _turned(rough))
    assert stiff_up < up - 5 and stiff_level < level - 5 and stiff_up + 5 < limp_down


def _turned(material: Material) -> list[np.ndarray]:
    return frictional_strip.turned_strip(material, 0.1, [np.pi / 4, 0.0, np.pi / 4], 9.81)


def test_the_loop_has_the_width_2HB_and_the_slopes_that_the_material_states() -> None:
    rough = Material(
        areal_density=0.2,
        stretch_stiffness=300.0,
        bending_rigidity=1e-5,
        bending_hysteresis=3e-4,
        bending_rigidity_initial=5e-5,
    )
    path = np.concatenate([np.linspace(0, 250, 2501), np.linspace(250, -250, 5001), np.linspace(-250, 250, 5001)])
    moment = frictional_strip.loop(rough, path.tolist())
    assert_allclose(moment[1] / path[1], 5e-5, rtol=1e-6)
    down, up = moment[2501 + 2500], moment[7502 + 2500]  # both at no curvature
    assert_allclose(up - down, 2 * 3e-4, rtol=1e-6)
    assert_allclose((moment[2500] - moment[2400]) / 10, 1e-5, rtol=1e-6)
    assert_allclose(frictional_strip.residual_curvature(rough, 250.0), 3e-4 / 1e-5, rtol=1e-6)
