"""Rollouts of the embedded simulator against what a textbook says of them."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.stats import spearmanr

from tatamu import Cloth, Scene, SimulationError, Table, simulate, simulate_many
from tatamu.base.errors import SceneError
from tatamu.simulation import native
from tatamu.simulation.mesh.topology import areas, lumped
from tatamu.simulation.native import LimitOptions, Options, StepOptions, precompile, simulation
from tests.physics.checks.refinement import TOWEL, score
from tests.physics.manipulations import EDGE, RandomFold
from tests.physics.manipulations import scene_of as folded
from tests.physics.subject import Subject
from tests.scenes import CLOTH, held, scene, sheet, together


def test_free_fall_follows_the_parabola() -> None:
    rollout = simulate(scene(cloth=sheet(height=5.0), table=None))
    fall = 5.0 - rollout.positions[-1, :, 2]
    assert fall == pytest.approx(9.81 * 0.5**2 / 2, rel=1e-3)
    assert np.abs(rollout.positions[-1] - rollout.positions[0])[:, :2].max() < 1e-7  # forces are in single precision


def test_a_cloth_at_rest_stays_half_a_thickness_over_the_table() -> None:
    rollout = simulate(scene())
    assert np.abs(rollout.positions - rollout.positions[0]).max() < 1e-6


def test_a_cloth_that_starts_in_the_table_comes_up_without_a_jump() -> None:
    rollout = simulate(scene(cloth=sheet(height=0.0)))
    assert rollout.positions[-1, :, 2] == pytest.approx(CLOTH.thickness / 2, abs=1e-5)
    assert rollout.positions[..., 2].max() < CLOTH.thickness


@pytest.mark.parametrize("mu", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("off", [-0.2, 0.2])
def test_an_incline_holds_the_cloth_up_to_the_friction_angle(mu: float, off: float) -> None:
    tilt = np.arctan(mu) + np.radians(off)
    flat = sheet(height=CLOTH.thickness / 2)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    cloth = Cloth(vertices=flat.vertices @ turn.T, faces=flat.faces)
    material = CLOTH.model_copy(update={"friction_table": mu})
    rollout = simulate(scene(cloth=cloth, material=material, table=Table(tilt=tilt), duration=1.0))
    way = np.linalg.norm(rollout.positions[-1] - rollout.positions[0], axis=1)
    if off < 0:
        assert way.max() < 1e-4
    else:
        expected = 0.5 * 9.81 * (np.sin(tilt) - mu * np.cos(tilt))
        assert way == pytest.approx(expected, rel=0.01)


def test_a_hung_sheet_stretches_by_half_its_weight() -> None:
    cloth = sheet(0.1, 0.3, 0.02)
    turned = Cloth(vertices=cloth.vertices[:, [2, 1, 0]], faces=cloth.faces)  # length along z
    top = np.flatnonzero(turned.vertices[:, 2] > 0.15 - 1e-9)
    material = CLOTH.model_copy(update={"poisson_ratio": 0.0, "air_drag": 2.0})
    rollout = simulate(scene(cloth=turned, material=material, table=None, grippers=[held(top)], duration=2.0))
    sunk = turned.vertices[:, 2].min() - rollout.positions[-1, :, 2].min()
    assert sunk / 0.3 == pytest.approx(CLOTH.areal_density * 9.81 * 0.3 / (2 * CLOTH.stretch_stiffness), rel=0.03)


def test_hands_follow_their_path_exactly_and_let_go() -> None:
    corner = np.array([0, 1])
    hand = held(corner, closes=0.1, opens=0.4, times=[0.1, 0.3], displacements=[[0.0, 0.0, 0.0], [0.02, 0.01, 0.05]])
    rollout = simulate(scene(grippers=[hand], duration=0.8))
    start = rollout.positions[0, corner]
    at = {round(t, 4): p[corner] for t, p in zip(rollout.times, rollout.positions, strict=True)}
    assert at[0.2] == pytest.approx(start + np.array([0.01, 0.005, 0.025]), abs=1e-6)
    assert at[0.35] == pytest.approx(start + np.array([0.02, 0.01, 0.05]), abs=1e-6)
    assert (at[0.8][:, 2] < 0.02).all()


def test_no_layer_comes_closer_than_nine_tenths_of_a_thickness() -> None:
    lower, upper = sheet(0.2, 0.2, 0.02, CLOTH.thickness / 2), sheet(0.15, 0.15, 0.017, 0.01)
    rollout = simulate(scene(cloth=together(lower, upper), duration=1.0))
    height = rollout.positions[-1, len(lower.vertices) :, 2]
    assert height.min() > 1.4 * CLOTH.thickness
    assert height.max() < 1.6 * CLOTH.thickness


def _pulled() -> Scene:
    cloth = sheet()
    left, right = (np.flatnonzero(s * cloth.vertices[:, 0] > 0.1 - 1e-9) for s in (-1, 1))
    away = held(right, times=[0.0, 0.3], displacements=[[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]])
    return scene(cloth=cloth, table=None, grippers=[held(left), away])


def test_a_cloth_pulled_apart_ends_in_an_error_that_names_the_limit() -> None:
    with pytest.raises(SimulationError, match=r"stretched to .* the limit is 1\.5"):
        simulate(_pulled())


def test_a_hand_that_jumps_is_named() -> None:
    jump = held(np.array([0]), times=[0.1, 0.101], displacements=[[0.0, 0.0, 0.0], [0.1, 0.0, 0.2]])
    with pytest.raises(
        SceneError,
        match=r"^grippers\.0: must not move faster than 10 m/s, given 2\d\d m/s at t "
        "= 0\.1",
    ):
        simulate(scene(grippers=[jump]))


def test_cloth_that_starts_stretched_is_named() -> None:
    """Its edges are no longer than at rest: it is stretched across them."""
    cloth = Cloth(
        vertices=0.02 * np.array([[0, 0, 1.0], [0, 1, 1], [1, 0, 1], [1, 1, 1]]),
        faces=np.array([[0, 2, 1], [1, 2, 3]]),
        rest_vertices=0.02 * np.array([[0, 0, 0.0], [0, -1, 0], [1, 0, 0], [1, 1, 0]]),
    )
    with pytest.raises(
        SceneError, match=r"^cloth\.vertices: must not stretch a triangle to more than 1\.5 .* in triangle 1$"
    ):
        simulate(scene(cloth=cloth))


def test_the_same_scene_gives_the_same_bytes_alone_and_among_others() -> None:
    hand = held(np.array([0]), times=[0.0, 0.4], displacements=[[0.0, 0.0, 0.0], [0.1, 0.0, 0.05]])
    one, other = scene(grippers=[hand]), scene(duration=0.2)
    alone = simulate(one).positions
    assert simulate(one).positions.tobytes() == alone.tobytes()
    assert simulate_many([other, one])[1].positions.tobytes() == alone.tobytes()


def _lumped_mass(cloth: Cloth) -> np.ndarray:
    return lumped(areas(cloth.rest, cloth.faces) * CLOTH.areal_density, cloth.faces, len(cloth.vertices))


def test_a_flying_sheet_keeps_its_momentum_and_gains_no_energy() -> None:
    cloth = sheet(height=1.0)
    wave = cloth.vertices.copy()
    wave[:, 2] += 0.01 * np.sin(30 * wave[:, 0])
    bent = Cloth(vertices=wave, faces=cloth.faces, rest_vertices=cloth.vertices)
    rollout = simulate(scene(cloth=bent, table=None, gravity=0.0, duration=1.0, frame_rate=1000.0))
    mass = _lumped_mass(cloth)[:, None]
    centre = (mass * rollout.positions).sum(1) / mass.sum()
    assert np.abs(centre - centre[0]).max() < 1e-7  # forces are in single precision
    kinetic = (mass * (np.diff(rollout.positions, axis=0) * 1000.0) ** 2).sum((1, 2)) / 2
    assert kinetic[500:].max() < 1.02 * kinetic[:500].max()


def test_loading_kernels_counts_as_setup_not_as_part_of_the_rollout(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]

    def load(*given: Any) -> Any:
        now[0] += 100.0
        return precompile.load(*given)

    monkeypatch.setattr(native, "perf_counter", lambda: now[0])
    monkeypatch.setattr(simulation, "load", load)
    info = simulate(scene(duration=0.1)).info
    assert (info["setup_seconds"], info["wall_seconds"]) == (100.0, 0.0)


KERNELS = """
import sys
import numpy as np
from numba.core.dispatcher import Dispatcher
from tatamu import simulate
from tatamu.simulation.native import prepare
from tests.scenes import held, scene

def loaded():
    modules = [module for name, module in sys.modules.items() if name.startswith("tatamu.simulation.native")]
    kernels = [kernel for module in modules for kernel in vars(module).values() if isinstance(kernel, Dispatcher)]
    return {kernel for kernel in kernels if kernel.overloads}

prepare()
before = loaded()
simulate(scene(grippers=[held(np.array([0, 1]), opens=0.1)], duration=0.2))
print(len(before), *(kernel.py_func.__name__ for kernel in loaded() - before))
"""


def test_the_first_rollout_needs_no_kernel_that_was_not_loaded_before_it() -> None:
    count, *late = subprocess.check_output([sys.executable, "-c", KERNELS], text=True).split()
    assert int(count) > 0
    assert late == []


def test_info_says_what_a_rollout_must_say() -> None:
    info = simulate(scene(duration=0.1)).info
    assert {"simulator", "version", "wall_seconds", "setup_seconds", "steps", "warnings"} <= set(info)
    assert info["simulator"] == "native"


@pytest.mark.parametrize(("times", "told"), [([0.0, 0.2], False), ([0.0, 20.0], True)])
def test_a_motion_that_the_scene_does_not_reach_is_told(times: list[float], told: bool) -> None:
    lifts = held(np.array([0, 1]), times=times, displacements=[[0.0, 0.0, 0.0], [0.0, 0.0, 0.02]])
    lines = simulate(scene(grippers=[lifts], duration=0.3)).info["warnings"]
    said = "grippers.0: the motion lasts until 20 s, but the scene ends at 0.3 s"
    assert any(line.startswith(said) for line in lines) == told


@pytest.mark.parametrize("rate", [60.0, 70.0, 24.0])
def test_a_scene_that_is_shorter_than_a_frame_is_told_with_what_helps(rate: float) -> None:
    made = scene(frame_rate=rate, duration=0.9 / rate)
    (line,) = (line for line in simulate(made).info["warnings"] if "the rollout contains only the first frame" in line)
    longer = float(line.removesuffix(" s").split()[-1])
    assert simulate(made.model_copy(update={"duration": longer})).positions.shape[0] == 2


def test_frames_of_a_large_rollout_are_kept_in_single_precision() -> None:
    made = scene(cloth=sheet(height=0.3), duration=0.4)
    double = simulate(made).positions
    limits = LimitOptions(most_bytes_in_double=double.nbytes - 1)
    single = native.simulate(made, Options(limits=limits)).positions
    assert (double.dtype, single.dtype) == (np.float64, np.float32)
    assert (single == double.astype(np.float32)).all()
    assert np.ptp(double[:, 0, 2]) > 0.2


@pytest.mark.slow
def test_half_the_time_step_keeps_the_order_of_folds() -> None:
    folds = [folded(RandomFold.random(100 + seed, fast=False), TOWEL, 0.02, EDGE) for seed in range(30)]
    steps = StepOptions()
    halved = Options(step=StepOptions(steps.outer_step / 2, steps.membrane_phase / 2, steps.bending_phase / 2))
    subject = Subject.named("native")
    finer = replace(subject, simulate=partial(native.simulate, options=halved))
    whole = np.array([score(subject, fold) for fold in folds])
    half = np.array([score(finer, fold) for fold in folds])
    assert (half != whole).any()
    assert spearmanr(whole, half).statistic >= 0.95
    assert half[whole.argmin()] - half.min() < 0.002
