"""Contact of cloth with rigid bodies in `native`."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from tatamu.simulation.body import Body
from tatamu.simulation.clearance import distances
from tatamu.simulation.material import Material
from tatamu.simulation.native import simulate
from tatamu.simulation.native.contact.bodies.rounded_box import BISECTIONS, along_edge, distance
from tatamu.simulation.scene import Cloth, Scene
from tests.physics.checks.bodies import deepest_poke
from tests.physics.meshes import staggered
from tests.physics.scenes import held

FABRIC = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-5, thickness=0.001)


def gaps(scene: Scene, positions: np.ndarray, times: np.ndarray) -> float:
    """Least distance of the mid-surface from any body in any frame, in thicknesses."""
    least = [
        distances(body, points, scene.cloth.faces, time, below=0.45 * scene.material.thickness).min()
        for points, time in zip(positions, times, strict=True)
        for body in scene.bodies
    ]
    return float(min(least)) / scene.material.thickness


def test_the_kernel_measures_as_the_body_does() -> None:
    random = np.random.default_rng(1)
    for body in (
        Body(shape="box", size=[0.3, 0.2, 0.1], positions=[[0, 0, 0]]),
        Body(shape="capsule", size=[0.1, 0.3], positions=[[0, 0, 0]]),
        Body(shape="sphere", size=[0.2], positions=[[0, 0, 0]]),
    ):
        for point in random.uniform(-0.5, 0.5, (200, 3)):
            found, *normal = distance(body.core, body.radius, *point)
            assert found == pytest.approx(float(body.distance(point)), abs=1e-12)
            step = 1e-6 * np.array(normal)
            assert float(body.distance(point + step)) - found == pytest.approx(1e-6, rel=1e-3)


def test_the_nearest_point_of_an_edge_is_found() -> None:
    half = np.array([0.3, 0.2, 0.1])
    random = np.random.default_rng(2)
    parts = np.linspace(0.0, 1.0, 2001)[:, None]
    body = Body(shape="box", size=[0.3, 0.2, 0.1], positions=[[0, 0, 0]])
    inside = 0
    for a, b in random.uniform(-0.6, 0.6, (200, 2, 3)):
        s = along_edge(half, 0.0, a, b, np.inf)
        sampled = body.distance(a + parts * (b - a))
        if s < 0.0:
            assert sampled.min() >= min(sampled[0], sampled[-1]) - 1e-9
        else:
            inside += 1
            last = float(np.linalg.norm(b - a)) / 2**BISECTIONS  # the distance changes by no more than that
            assert float(body.distance(a + s * (b - a))) <= sampled.min() + last
    assert inside > 20


@pytest.mark.parametrize("spacing", [0.013, 0.026])
@pytest.mark.parametrize("speed", [0.6, 2.0])
def test_a_thin_finger_does_not_jump_through_the_cloth(spacing: float, speed: float) -> None:
    plan, faces = staggered(0.13, 0.13, spacing)
    sides = np.flatnonzero((plan[:, 0] < 1e-9) | (plan[:, 0] > plan[:, 0].max() - 1e-9))
    cloth = Cloth(vertices=np.column_stack([plan, np.zeros(len(plan))]), faces=faces)
    up = 0.04
    for place in (0.061, 0.067):
        start = np.array([place, 0.063, -0.03])
        finger = Body(
            shape="box",
            size=[0.004, 0.004, 0.02],
            times=[0.0, up / speed],
            positions=[start, start + np.array([0.0, 0.0, up])],
        )
        scene = Scene(
            cloth=cloth, material=FABRIC, grippers=[held(sides)], bodies=[finger], duration=0.15, frame_rate=100
        )
        rollout = simulate(scene)
        assert gaps(scene, rollout.positions, rollout.times) > 0.25
        assert rollout.positions[-1, :, 2].max() > 0.02


def test_a_board_lifts_a_cloth() -> None:
    plan, faces = staggered(0.1, 0.1, 0.0125)
    cloth = Cloth(vertices=np.column_stack([plan - 0.05, np.zeros(len(plan))]), faces=faces)
    board = Body(shape="box", size=[0.03, 0.03, 0.004], positions=[[0, 0, -0.0045], [0, 0, 0.1]], times=[0.1, 0.4])
    scene = Scene(cloth=cloth, material=FABRIC, bodies=[board], duration=0.6, frame_rate=50)
    rollout = simulate(scene)
    assert rollout.positions[-1, :, 2].max() == pytest.approx(0.1045, abs=0.005)
    assert gaps(scene, rollout.positions, rollout.times) > 0.4


def test_the_same_scene_gives_the_same_bytes() -> None:
    plan, faces = staggered(0.1, 0.1, 0.02)
    cloth = Cloth(vertices=np.column_stack([plan - 0.05, np.full(len(plan), 0.001)]), faces=faces)
    ball = Body(shape="sphere", size=[0.03], positions=[[0.004, 0.002, -0.03]])
    scene = Scene(cloth=cloth, material=FABRIC, bodies=[ball], duration=0.2)
    assert simulate(scene).positions.tobytes() == simulate(scene).positions.tobytes()


def test_a_finger_leaves_the_cells_that_its_hand_holds_and_meets_all_others() -> None:
    plan, faces = staggered(0.1, 0.1, 0.025)
    cloth = Cloth(vertices=np.column_stack([plan, np.zeros(len(plan))]), faces=faces)
    side = np.flatnonzero(plan[:, 0] < 1e-9)
    grip = held(side).model_copy(update={"hand": "left"})

    def lifted(hand: Literal["left", "right"], x: float) -> float:
        """How high a finger that comes up beside the side at x lifts the cloth [m]."""
        finger = Body(
            shape="box",
            size=[0.003, 0.06, 0.01],
            hand=hand,
            times=[0.0, 0.05],
            positions=[[x, 0.05, -0.02], [x, 0.05, 0.0]],
        )
        scene = Scene(
            cloth=cloth, material=FABRIC, grippers=[grip], bodies=[finger], gravity=0.0, duration=0.06, frame_rate=100
        )
        return float(simulate(scene).positions[-1, :, 2].max())

    assert lifted("left", 0.008) < 1e-6 < 5e-3 < lifted("right", 0.008)
    assert lifted("left", 0.06) > 5e-3


@pytest.mark.parametrize("seed", [335, 343])
def test_a_corner_of_a_finger_is_on_the_side_of_a_face_from_which_it_came(seed: int) -> None:
    """The planes of these faces cut the finger beside the faces, so its centre is on the other side."""
    depth = deepest_poke(simulate, seed)
    assert depth is not None and depth < 0.1
