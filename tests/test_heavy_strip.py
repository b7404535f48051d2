"""The heavy strip: the cantilever against a table, the loop of a fold against itself solved by another method."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import nnls

from tatamu.base.errors import TatamuError
from tatamu.simulation import heavy_strip
from tatamu.simulation.heavy_strip import (
    AFTER,
    HALF_LENGTH,
    LINKS,
    STEP,
    cantilever,
    chord,
    crease,
    least_energy,
    nodes,
    tip,
)
from tests.physics import chain as chain_module
from tests.physics.chain import ChainEnergy, FoldedStrip

THICKNESSES = (0.0135, 0.077, 0.3, 1.0, 4 / 3)
"""In bending lengths: from a limp sheet on which t hardly matters to cloth folded round a circle."""


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
    x, y, theta = tip(gamma)
    assert_allclose([x, y], [reach, drop], atol=2e-5)
    assert_allclose(np.degrees(theta), slope, atol=2e-2)


def test_cantilever_keeps_its_length() -> None:
    shape = cantilever(30.0, 2001)
    assert_allclose(np.linalg.norm(np.diff(shape, axis=0), axis=1).sum(), 1.0, rtol=1e-5)


def test_a_stiff_cantilever_drops_by_an_eighth_of_gamma() -> None:
    assert_allclose(tip(0.02)[1], 0.02 / 8, rtol=1e-3)


def test_the_astm_angle_is_reached_at_twice_the_bending_length() -> None:
    assert_allclose(np.degrees(chord(8.0)), 41.49, atol=0.01)


def test_chain_has_the_gradient_and_curvature_of_its_energy() -> None:
    chain = ChainEnergy(FoldedStrip(0.4, 0.037, 0.001, 0.004), 30)
    chain.push[:], chain.pull[:] = 0.02, 0.3
    theta = chain.start() + 0.1 * np.random.default_rng(0).normal(size=30)
    steps = 1e-6 * np.eye(30)
    slope = [(chain.value(theta + e) - chain.value(theta - e)) / 2e-6 for e in steps]
    assert_allclose(chain.slope(theta), slope, atol=1e-6)
    for step in steps[::7]:
        curved = (chain.slope(theta + step) - chain.slope(theta - step)) / 2
        assert_allclose(chain.curved(theta, step), curved, atol=1e-11)


@pytest.mark.parametrize(("bending_length", "height", "reach"), [(0.037, 33.8, 187.6), (0.022, 20.2, 192.7)])
def test_the_chain_agrees_with_one_made_apart(bending_length: float, height: float, reach: float) -> None:
    nodes = 1e3 * FoldedStrip(0.4, bending_length, 0.001, 0.004).solve()
    assert_allclose(nodes[:, 1].max(), height, atol=0.6)  # that chain lay on z = 0, this one half a thickness higher
    assert_allclose(nodes[:, 0].max(), reach, atol=0.4)
    assert_allclose(nodes[-1], [0.0, 4.5], atol=1e-3)
    assert nodes[: len(nodes) // 2, 1].min() > 0.49
    assert nodes[len(nodes) // 2 :, 1].min() > 1.49


def test_the_chain_does_not_depend_on_its_links() -> None:
    strip = FoldedStrip(0.3, 0.022, 0.001, 0.004)
    assert_allclose(strip.solve(100)[:, 1].max(), strip.solve(200)[:, 1].max(), rtol=0.01)


def test_a_chain_that_is_not_at_rest_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chain_module, "PENALTIES", (1e2,))  # one round of multipliers leaves a constraint unmet
    with pytest.raises(TatamuError, match="no equilibrium"):
        FoldedStrip(0.3, 0.022, 0.001, 0.004).solve(100)


# --- the crease of a fold


@pytest.mark.parametrize(("bending_length", "thickness"), [(0.037, 0.0005), (0.022, 0.0005), (0.026, 0.002)])
def test_crease_and_chain_find_one_loop_by_two_methods(bending_length: float, thickness: float) -> None:
    """Of as many links they differ by the ends of their minimisations alone; the rest is discretisation."""
    profile = crease(bending_length, thickness)
    strip = FoldedStrip(2 * HALF_LENGTH * bending_length, bending_length, thickness, thickness)
    chain = strip.solve(LINKS)
    assert chain[:, 1].max() == pytest.approx(profile.z.max(), rel=1e-4)
    assert HALF_LENGTH * bending_length - chain[:, 0].max() == pytest.approx(profile.x.min(), abs=1e-6)
    assert strip.solve(4 * LINKS)[:, 1].max() == pytest.approx(profile.z.max(), rel=4e-3)


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_a_crease_is_flush_and_rests_on_the_table_and_on_itself(thickness: float) -> None:
    x, z = nodes(least_energy(thickness), thickness)
    assert (x[-1], z[-1]) == pytest.approx((HALF_LENGTH, 1.5 * thickness), abs=1e-7)
    assert z[: LINKS // 2].min() == pytest.approx(0.5 * thickness, abs=1e-7)
    assert z[LINKS // 2 + 1 :].min() == pytest.approx(1.5 * thickness, abs=1e-7)


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_a_crease_is_in_equilibrium(thickness: float) -> None:
    """Bending and weight are balanced by the hold of the ends and by contacts that push: Karush, Kuhn and Tucker."""
    phi = least_energy(thickness)
    assert _unbalanced(phi, thickness) < 1e-3
    assert _unbalanced(heavy_strip.guess(), thickness) > 0.1


def _unbalanced(phi: np.ndarray, thickness: float) -> float:
    """Largest moment that nothing balances, over the largest of the weight [-]."""

    def energy(phi: np.ndarray) -> float:
        bend = np.diff(np.concatenate([[np.pi], phi, [0.0]]))
        return float(0.5 * bend @ bend / STEP + STEP * nodes(phi, thickness)[1].sum())

    step = 1e-5
    moment = [(energy(phi + e) - energy(phi - e)) / (2 * step) for e in step * np.eye(LINKS)]
    z = nodes(phi, thickness)[1]
    floor = np.where(np.arange(LINKS + 1) <= LINKS // 2, thickness / 2, 1.5 * thickness)
    touching = np.flatnonzero(z[:-1] - floor[:-1] < 1e-6)
    hold = np.stack([-np.sin(phi), np.cos(phi)])
    columns = np.vstack([hold, -hold, AFTER[touching] * np.cos(phi)])
    forces, _ = nnls(columns.T, np.array(moment), maxiter=10_000)
    return float(np.abs(columns.T @ forces - moment).max() / (STEP * STEP * LINKS))


def test_a_crease_that_is_not_found_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    lost = SimpleNamespace(success=False, message="iteration limit reached", x=heavy_strip.guess())
    monkeypatch.setattr(heavy_strip, "minimize", lambda *given, **more: lost)
    with pytest.raises(TatamuError, match=r"crease: .*0\.123.*iteration limit reached"):
        crease(1.0, 0.123)


def test_limp_cloth_gets_the_crease_of_the_limpest_that_is_computed() -> None:
    assert crease(0.001, 0.002).z == pytest.approx(crease(0.0015, 0.002).z, rel=1e-12)
