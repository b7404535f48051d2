"""Friction of bending: loops of moment against curvature, work of closed cycles, memory."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tatamu import simulate
from tatamu.simulation.material import Material
from tatamu.simulation.native.elastic import bending, hysteresis
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import capabilities
from tests.physics.checks.motion import rolled
from tests.physics.frictional_strip import loop
from tests.scenes import CLOTH
from tests.test_native_forces import Elastic, irregular, regular

ROUGH = CLOTH.model_copy(update={"bending_hysteresis": 8.0 * CLOTH.bending_rigidity})


class Rubbing(Elastic):
    """Bending of a mesh with hysteresis, in double precision, which remembers."""

    def __init__(self, mesh: tuple[np.ndarray, np.ndarray], material: Material = ROUGH) -> None:
        super().__init__(mesh, material)
        flat = np.zeros(len(self.topology.hinges))
        self.bent = bending.in_bands(self.hinges, self.curved, self.K, flat, material, np.float64)
        copies = len(self.bent.coupling_copies)
        slip = hysteresis.unslipped(self.bent.friction, np.zeros(self.hinges.size + copies), self.bent.couplings)
        self.measures = bending.scratch(self.bent.hinges, self.hinges.size, copies, np.float64, slip)

    def force(self, x: np.ndarray) -> np.ndarray:
        X = self._slotted(x, self.hinges)
        F = np.zeros_like(X)
        has_friction = self.bent.friction.area.size > 0
        add_force = bending.add_force_with_friction if has_friction else bending.add_force
        add_force(X, F, self.bent, self.measures)
        return self._gathered(F, self.hinges)

    def work(self, shapes: list[np.ndarray]) -> float:
        """Work that bending takes along a path of shapes [J], by the mean force of each step."""
        total = 0.0
        force = self.force(shapes[0])
        for before, after in pairwise(shapes):
            then = self.force(after)
            total -= 0.5 * float(((force + then) * (after - before)).sum())
            force = then
        return total


def wavy(sheet: Elastic, size: float, phase: float) -> np.ndarray:
    """A wave and a twist of some size [m]."""
    x, y = sheet.rest[:, 0], sheet.rest[:, 1]
    height = size * np.sin(20 * x + phase) + 8 * size * x * y * np.cos(phase)
    return sheet.rest + np.outer(height, [0.0, 0.0, 1.0])


@pytest.mark.parametrize("mesh", [regular, irregular])
def test_the_moment_of_a_cylinder_follows_the_loop(mesh: object) -> None:
    """The work of bending a sheet further, per area and curvature, is the moment of the loop."""
    sheet = Rubbing(mesh())  # type: ignore[operator]
    x = sheet.rest[:, 0]
    inner = 0.2 * 0.3 if mesh is irregular else 0.6 * 0.8
    path = np.concatenate([np.linspace(0, 0.3, 61), np.linspace(0.3, -0.1, 61)[1:]])
    scale = 8.0 / 0.3  # of curvatures small enough for a parabola to be a cylinder
    small = ROUGH.model_copy(update={"bending_hysteresis": ROUGH.bending_hysteresis / scale})
    sheet = Rubbing(mesh(), small)  # type: ignore[operator]
    moments = loop(small, path.tolist())
    bent = [sheet.rest + np.outer(0.5 * k * x**2, [0.0, 0.0, 1.0]) for k in path]
    way = np.outer(0.5 * x**2, [0.0, 0.0, 1.0])
    got = np.array([-(sheet.force(shape) * way).sum() for shape in bent]) / inner
    assert np.abs(got - moments).max() < 0.07 * np.abs(moments).max()  # borders bend less


def test_every_closed_cycle_takes_work() -> None:
    rng = np.random.default_rng(7)
    for size in (1e-5, 1e-3, 2e-2):
        sheet = Rubbing(irregular())
        corners = [wavy(sheet, size * float(rng.uniform(-1, 1)), float(rng.uniform(0, 6))) for _ in range(4)]
        corners.append(corners[0])
        path = [a + u * (b - a) for a, b in pairwise(corners) for u in np.linspace(0, 1, 40)]
        elastic = Elastic(irregular())
        taken = [sheet.work(path) for _ in range(3)]  # the first cycle begins unbent
        scale = max(elastic.bending_energy(corner) for corner in corners)
        assert all(work > -1e-3 * scale for work in taken)
        if size == 2e-2:
            assert min(taken) > 0.05 * scale


def test_within_the_first_yield_curvature_nothing_is_forgotten() -> None:
    sheet = Rubbing(irregular())
    sheet.force(wavy(sheet, 4e-3, 0.0))
    held = wavy(sheet, 3.9e-3, 0.0)
    before = sheet.force(held)
    for turn in range(200):
        sheet.force(wavy(sheet, 3.9e-3 + 1e-5 * (-1) ** turn, 0.0))
    np.testing.assert_allclose(sheet.force(held), before, rtol=1e-9, atol=1e-9 * np.abs(before).max())


def test_without_hysteresis_the_force_is_that_of_the_elastic_sheet() -> None:
    smooth = Rubbing(irregular(), CLOTH)
    x = wavy(smooth, 3e-3, 0.4)
    assert np.array_equal(smooth.force(x), Elastic(irregular()).bending_force(x))


def test_a_roll_stays_rolled_and_one_without_hysteresis_opens() -> None:
    cloth, _ = rolled(0.1, 0.04, 0.01, 30.0)
    fabric = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4, air_drag=60.0)
    rough = fabric.model_copy(update={"bending_hysteresis": 1e-3})
    ends = []
    for material in (fabric, rough):
        end = simulate(Scene(cloth=cloth, material=material, gravity=0.0, duration=3.0)).positions[-1]
        ends.append(float(np.ptp(end[:, 0]) ** 2 + np.ptp(end[:, 2]) ** 2) ** 0.5)
    assert ends[0] > 0.0999 and ends[1] < 0.098


def test_a_material_with_a_slope_below_its_rigidity_is_refused() -> None:
    with pytest.raises(ValueError, match="bending_rigidity_initial must be more than"):
        Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-5, bending_rigidity_initial=1e-5)
    assert "bending_hysteresis" not in CLOTH.model_dump()


def test_only_native_knows_hysteresis_and_the_others_say_so() -> None:
    assert capabilities("native").lacking(ROUGH) == []
    assert capabilities("mujoco").lacking(ROUGH) == ["bending_hysteresis: ignored, so bending is elastic"]


def test_cells_that_lock_are_warned_of_with_the_spacing_that_would_not() -> None:
    cloth, _ = rolled(0.1, 0.04, 0.01, 0.1)
    limp = Material(areal_density=0.1, stretch_stiffness=1000.0, bending_rigidity=1e-6)
    lines = simulate(Scene(cloth=cloth, material=limp, duration=0.02)).info["warnings"]
    assert any("Y h^2 / B" in line for line in lines)
    plain = limp.model_copy(update={"bending_rigidity": 1e-4})
    assert simulate(Scene(cloth=cloth, material=plain, duration=0.02)).info["warnings"] == []
