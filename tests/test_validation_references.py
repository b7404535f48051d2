from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tatamu.material import Material
from tatamu.validation import elastica, references
from tatamu.validation.loop import Crease, _Chain

# Gamma, X/L, Y/L, slope of the tip [deg]: computed apart from this repository, by other meshes and tolerances
TABLE = [
    (1, 0.99125, 0.12347, 9.460),
    (4, 0.89011, 0.42516, 33.724),
    (10, 0.65635, 0.70020, 60.312),
    (30, 0.34276, 0.87309, 82.972),
    (100, 0.15922, 0.93752, 89.617),
    (1000, 0.04599, 0.98114, 90.0),
]


@pytest.mark.parametrize(("gamma", "reach", "drop", "slope"), TABLE)
def test_cantilever_agrees_with_the_table(gamma: float, reach: float, drop: float, slope: float) -> None:
    x, y, theta = elastica.tip(gamma)
    assert_allclose([x, y], [reach, drop], atol=2e-5)
    assert_allclose(np.degrees(theta), slope, atol=2e-2)


def test_cantilever_keeps_its_length() -> None:
    shape = elastica.cantilever(30.0, 2001)
    assert_allclose(np.linalg.norm(np.diff(shape, axis=0), axis=1).sum(), 1.0, rtol=1e-5)


def test_a_stiff_cantilever_drops_by_an_eighth_of_gamma() -> None:
    assert_allclose(elastica.tip(0.02)[1], 0.02 / 8, rtol=1e-3)


def test_the_astm_angle_is_reached_at_twice_the_bending_length() -> None:
    assert_allclose(np.degrees(elastica.chord(8.0)), 41.49, atol=0.01)


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


def test_chain_has_the_gradient_and_curvature_of_its_energy() -> None:
    chain = _Chain(Crease(0.4, 0.037, 0.001, 0.004), 30)
    chain.push[:], chain.pull[:] = 0.02, 0.3
    theta = chain.start() + 0.1 * np.random.default_rng(0).normal(size=30)
    steps = 1e-6 * np.eye(30)
    slope = [(chain.value(theta + e) - chain.value(theta - e)) / 2e-6 for e in steps]
    assert_allclose(chain.slope(theta), slope, atol=1e-6)
    for step in steps[::7]:
        curved = (chain.slope(theta + step) - chain.slope(theta - step)) / 2
        assert_allclose(chain.curved(theta, step), curved, atol=1e-11)


@pytest.mark.parametrize(("bending_length", "height", "reach"), [(0.037, 33.8, 187.6), (0.022, 20.2, 192.7)])
def test_crease_agrees_with_a_chain_made_apart(bending_length: float, height: float, reach: float) -> None:
    nodes = 1e3 * Crease(0.4, bending_length, 0.001, 0.004).solve()
    assert_allclose(nodes[:, 1].max(), height, atol=0.6)  # that chain lay on z = 0, this one half a thickness higher
    assert_allclose(nodes[:, 0].max(), reach, atol=0.4)
    assert_allclose(nodes[-1], [0.0, 4.5], atol=1e-3)
    assert nodes[: len(nodes) // 2, 1].min() > 0.49
    assert nodes[len(nodes) // 2 :, 1].min() > 1.49


def test_crease_does_not_depend_on_its_links() -> None:
    crease = Crease(0.3, 0.022, 0.001, 0.004)
    assert_allclose(crease.solve(100)[:, 1].max(), crease.solve(200)[:, 1].max(), rtol=0.01)
