"""Rigid bodies in scenes: what is refused, where they are, how far cloth is from them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.base.files import validated
from tatamu.show.solids import moving, solid, together
from tatamu.simulation.body import Body, rotation, slerp
from tatamu.simulation.clearance import deepest, distances
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import Capabilities
from tests.refusals import refusal

BOX = {"shape": "box", "size": [0.02, 0.01, 0.004], "positions": [[0, 0, 0.1]]}
CLOTH = {"vertices": [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], "faces": [[0, 1, 2]]}
MATERIAL = {"areal_density": 0.2, "stretch_stiffness": 300.0, "bending_rigidity": 1e-5, "thickness": 0.001}


def scene(**body: Any) -> Scene:
    raw = {"cloth": CLOTH, "material": MATERIAL, "duration": 0.1, "bodies": [{**BOX, **body}]}
    return validated(Scene, raw, "scene.json")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"size": [0.02, 0.0, 0.004]}, "bodies.0.size.1"),
        ({"size": [0.02]}, "size must have 3 numbers for a box, given 1"),
        ({"shape": "capsule"}, "size must have 2 numbers for a capsule, given 3"),
        ({"shape": "cone"}, "bodies.0.shape"),
        ({"orientations": [[0, 0, 0, 0]]}, "must be unit quaternions [w, x, y, z], given length 0 in row 0"),
        ({"orientations": [[2, 0, 0, 0]]}, "given length 2 in row 0"),
        ({"orientations": [[1, 0, 0]]}, "must be a list of quaternions [w, x, y, z]"),
        ({"orientations": [[float("nan"), 0, 0, 0]]}, "unit quaternions"),
        ({"times": [0.0, 0.0], "positions": [[0, 0, 1], [0, 0, 1]]}, "times must increase"),
        ({"times": [0.0, 1.0]}, "positions must have one item for each of 2 times, given 1"),
        ({"times": [1.0, 0.5], "positions": [[0, 0, 1], [0, 0, 1]]}, "times must increase"),
        ({"friction": -1.0}, "bodies.0.friction"),
        (
            {"positions": [[0.02, 0.02, 0.002]]},
            "bodies.0 begins 0.0025 m deep in the cloth, more than the cloth's thickness",
        ),
        ({"speed": 1.0}, "bodies.0.speed"),
    ],
)
def test_a_wrong_body_is_one_line(wrong: dict[str, Any], words: str) -> None:
    said = refusal(scene, **wrong)
    assert words in said and said.startswith("scene.json: ")


def test_a_thin_finger_may_not_begin_in_a_face_between_its_vertices() -> None:
    with pytest.raises(InputError, match=r"bodies\.0 begins .* m deep in the cloth"):
        scene(shape="capsule", size=[0.002, 0.01], positions=[[0.03, 0.03, 0.0]])
    scene(positions=[[0.03, 0.03, 0.0041]])  # its lower side is 0.1 mm above the mid-surface: inside by 0.4 mm


def test_a_scene_with_bodies_is_read_as_it_was_written(tmp_path: Any) -> None:
    given = scene(times=[0.0, 1.0], positions=[[0, 0, 0.1], [0, 0, 0.2]], orientations=[[1, 0, 0, 0], [0, 1, 0, 0]])
    given.save(tmp_path / "scene.json")
    assert Scene.load(tmp_path / "scene.json").model_dump_json() == given.model_dump_json()


def test_a_body_turns_the_shorter_way_and_is_held_after_the_last_knot() -> None:
    quarter = np.array([[1.0, 0, 0, 0], [-np.sqrt(0.5), -np.sqrt(0.5), 0, 0]])  # -q turns as q does: by 90 degrees
    found = slerp(np.array([-1.0, 0.0, 0.5, 1.0, 9.0]), np.array([0.0, 1.0]), quarter)
    turns = [np.degrees(2 * np.arctan2(np.linalg.norm(q[1:]), abs(q[0]))) for q in found]
    assert turns == pytest.approx([0, 0, 45, 90, 90])
    assert rotation(found[3]) @ [0, 1, 0] == pytest.approx([0, 0, 1])


def test_distances_are_those_of_the_shapes() -> None:
    box = Body(shape="box", size=[1, 2, 3], positions=[[0, 0, 0]])
    points = np.array([[2.0, 0, 0], [2, 3, 3], [0, 0, 0], [0.5, 0, 0]])
    assert box.distance(points) == pytest.approx([1, np.sqrt(2), -1, -0.5])
    capsule = Body(shape="capsule", size=[0.5, 1.0], positions=[[0, 0, 0]])
    assert capsule.distance(np.array([[1.0, 0, 0.9], [0, 0, 2.0], [0, 0, 0.5]])) == pytest.approx([0.5, 0.5, -0.5])
    sphere = Body(shape="sphere", size=[0.5], positions=[[0, 0, 0]])
    assert sphere.distance(np.array([[0.0, 0, 0], [0, 3, 4]])) == pytest.approx([-0.5, 4.5])


def test_clearance_is_that_of_a_fine_grid_over_each_triangle() -> None:
    random = np.random.default_rng(0)
    weights = random.dirichlet([1, 1, 1], 20000)
    for body in (
        Body(shape="box", size=[0.3, 0.2, 0.1], positions=[[0, 0, 0]]),
        Body(shape="capsule", size=[0.1, 0.3], positions=[[0, 0, 0]]),
    ):
        for corners in random.uniform(-0.6, 0.6, (20, 3, 3)):
            found = distances(body, corners, np.array([[0, 1, 2]]), 0.0)[0]
            sampled = body.distance(weights @ corners).min()
            assert found <= sampled + 1e-6
            assert found == pytest.approx(sampled, abs=0.01)


def test_depth_is_positive_inside() -> None:
    sphere = Body(shape="sphere", size=[0.01], positions=[[0.03, 0.03, 0.0]])
    points = np.array(CLOTH["vertices"], dtype=float)
    assert deepest(sphere, points, np.array([[0, 1, 2]])) == pytest.approx(0.01, abs=1e-6)


def test_a_simulator_without_bodies_refuses_the_scene() -> None:
    with pytest.raises(InputError, match=r"bodies: blender cannot simulate rigid bodies, given 1"):
        Capabilities().refuse(scene(), "blender")
    Capabilities(bodies=True).refuse(scene(), "native")


def test_pictures_draw_a_body_where_it_is() -> None:
    for shape, size in (("box", [0.3, 0.2, 0.1]), ("sphere", [0.1]), ("capsule", [0.1, 0.3])):
        body = Body(shape=shape, size=size, times=[0.0, 1.0], positions=[[0, 0, 0], [1, 0, 0]])
        points, faces = solid(body)
        assert body.distance(points) == pytest.approx(0.0, abs=0.003)
        assert faces.max() == len(points) - 1
        moved = moving([body, body], np.array([0.0, 0.5, 2.0]))
        assert moved is not None
        assert moved[0].mean(axis=1)[:, 0] == pytest.approx([0.0, 0.5, 1.0], abs=1e-6)
    assert moving([], np.array([0.0])) is None
    assert together(None, None) is None
