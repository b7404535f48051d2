"""Scene and rollout files: validated on reading, the same after a round trip."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from tatamu import InputError, Rollout, Scene, simulate
from tatamu.simulation.material import Material, load_material
from tatamu.simulation.scene import Cloth, Gripper, Table
from tests.refusals import refusal
from tests.scenes import CLOTH, held, scene


def plain() -> dict[str, Any]:
    value: dict[str, Any] = json.loads(scene(grippers=[held(np.array([0]))]).model_dump_json())
    return value


def changed(path: str, value: Any) -> dict[str, Any]:
    data = plain()
    *parents, last = path.split(".")
    part: Any = data
    for key in parents:
        part = part[int(key)] if key.isdigit() else part[key]
    part[last] = value
    return data


def test_a_scene_survives_a_round_trip(tmp_path: Path) -> None:
    original = scene(grippers=[held(np.array([3, 4]), opens=0.4)])
    original.save(tmp_path / "scene.json")
    again = Scene.load(tmp_path / "scene.json")
    assert again.model_dump_json() == original.model_dump_json()


@pytest.mark.parametrize(
    ("path", "value", "named"),
    [
        ("version", 2, "version"),
        ("cloth.vertices", [[0, 0]], "cloth.vertices"),
        ("cloth.vertices", [[0, 0, "a"]], "cloth.vertices"),
        ("cloth.vertices", [[0, 0, 1e9]], "cloth.vertices"),
        ("cloth.faces", [[0, 1, 999]], "triangle 0"),
        ("cloth.faces", [[0, 1, 1.5]], "cloth.faces"),
        ("cloth.faces", [], "at least one triangle"),
        ("cloth.faces", [[0, 1, 2]], "have an area"),
        ("cloth.faces", [[0, 1, 6]], "but vertex 2 belongs to none"),
        ("cloth.rest_vertices", [[0, 0, 0]], "rest_vertices"),
        ("cloth.seams", [[0, 1]], "seams"),
        ("material.areal_density", -1, "material.areal_density"),
        ("material.areal_density", float("nan"), "material.areal_density"),
        ("material.poisson_ratio", 1.0, "material.poisson_ratio"),
        ("material.colour", "red", "material.colour"),
        ("table.tilt", 2.0, "table.tilt"),
        ("grippers.0.vertices", [100000], "grippers.0.vertices"),
        ("grippers.0.vertices", [0, 0], "twice"),
        ("grippers.0.opens", 0.0, "opens"),
        ("grippers.0.times", [1.0, 1.0], "increase"),
        ("grippers.0.displacements", [[0, 0, 0], [0, 0, 0]], "displacements"),
        ("duration", 0, "duration"),
        ("duration", "long", "duration"),
        ("frame_rate", -1, "frame_rate"),
    ],
)
def test_a_wrong_field_is_named_in_one_line(tmp_path: Path, path: str, value: Any, named: str) -> None:
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(changed(path, value)))
    said = refusal(Scene.load, file)
    assert named in said and str(file) in said


def test_three_triangles_on_one_edge_are_no_cloth(tmp_path: Path) -> None:
    data = plain()
    data["cloth"]["vertices"] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]]
    data["cloth"]["faces"] = [[0, 1, 2], [0, 1, 3], [0, 1, 4]]
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(data))
    with pytest.raises(InputError, match=r"manifold, with at most 2 triangles at each edge, given 3 at edge \[0, 1\]"):
        Scene.load(file)


@pytest.mark.parametrize("wrong", [[0, 1], [0, 9], [0, 7], [2, 2]])
def test_a_seam_is_an_inner_edge_whichever_way_round(wrong: list[int]) -> None:
    corners = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]])
    faces = np.array([[0, 1, 3], [1, 2, 3]])
    for right in ([[1, 3]], [[3, 1]], [[3, 1], [1, 3]]):
        assert len(Cloth(vertices=corners, faces=faces, seams=np.array(right)).seams) == len(right)
        with pytest.raises(ValueError, match=rf"\[{wrong[0]}, {wrong[1]}\]"):
            Cloth(vertices=corners, faces=faces, seams=np.array([*right, wrong]))


@pytest.mark.parametrize("text", ["", "{", "[]", "7", '{"version": 1}'])
def test_what_is_no_scene_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "scene.json"
    file.write_text(text)
    with pytest.raises(InputError, match=r"scene\.json"):
        Scene.load(file)


def test_two_hands_may_not_hold_one_vertex_at_once() -> None:
    with pytest.raises(ValueError, match="must not hold the same vertex"):
        scene(grippers=[held(np.array([1, 2])), held(np.array([2, 3]))])


def test_two_hands_may_hold_one_vertex_in_turn() -> None:
    lifts = {"times": [0.2, 0.4], "displacements": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.02]])}
    first, second = held(np.array([1]), opens=0.2), Gripper(vertices=[1], closes=0.2, **lifts)
    for hands in ([first, second], [second, first]):
        rollout = simulate(scene(grippers=hands))
        risen = rollout.positions[:, 1, 2] - rollout.positions[0, 1, 2]
        assert risen[rollout.times > 0.4] == pytest.approx(0.02, abs=1e-9)


def test_a_rollout_survives_a_round_trip_without_pickles(tmp_path: Path) -> None:
    rollout = Rollout(
        np.arange(2.0), np.zeros((2, 3, 3)), np.array([[0, 1, 2]]), {"simulator": "x"}, {"target": np.ones((3, 3))}
    )
    rollout.save(tmp_path / "r.npz")
    again = Rollout.load(tmp_path / "r.npz")
    assert again.info == rollout.info
    assert (again.extra["target"] == 1.0).all()
    with np.load(tmp_path / "r.npz", allow_pickle=False) as archive:
        assert set(archive.files) == {"times", "positions", "faces", "info", "target"}


def test_what_is_no_rollout_is_refused(tmp_path: Path) -> None:
    (tmp_path / "r.npz").write_bytes(b"nothing")
    with pytest.raises(InputError, match="not a rollout"):
        Rollout.load(tmp_path / "r.npz")


def test_a_material_can_be_dumped_without_its_blender_table() -> None:
    for raw in (None, {"quality": 5}):
        assert "blender" not in CLOTH.model_copy(update={"blender": raw}).model_dump(exclude={"blender"})


def test_a_material_speaks_of_compression_only_where_it_differs_from_tension() -> None:
    assert "compression" not in CLOTH.model_dump() and "compression" not in CLOTH.model_dump_json()
    wrinkles = CLOTH.model_copy(update={"compression": 0.1})
    assert wrinkles.model_dump()["compression"] == 0.1
    assert Material.model_validate_json(wrinkles.model_dump_json()) == wrinkles


def test_whole_numbers_and_switches_in_a_blender_table_stay_what_they_are() -> None:
    raw = {"quality": 5, "mass": 0.3, "use_self_collision": True, "bending_model": "LINEAR"}
    dumped = Material(**{**CLOTH.model_dump(), "blender": raw}).model_dump_json()
    assert '"quality":5,"mass":0.3,"use_self_collision":true,"bending_model":"LINEAR"' in dumped
    assert CLOTH.model_copy(update={"blender": raw}).model_dump()["blender"] == raw  # a warning is an error here


@pytest.mark.parametrize("wrong", ["1.5e-5", True])
def test_a_number_is_neither_a_text_nor_a_truth_value(wrong: object, tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    scene().save(path)
    data = json.loads(path.read_text())
    data["material"]["bending_rigidity"] = wrong
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=f"bending_rigidity: .*given {wrong!r}"):
        Scene.load(path)


def test_a_field_that_stands_twice_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    scene().save(path)
    path.write_text(path.read_text().replace('"gravity":', '"gravity": 1.0, "gravity":', 1))
    with pytest.raises(InputError, match="gravity: must not occur twice"):
        Scene.load(path)


def test_a_material_of_an_unknown_name_tells_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"one of .*denim.*given 'nope'"):
        load_material(Path("nope"))


def test_a_triangle_alone_falls() -> None:
    cloth = Cloth(vertices=np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]), faces=np.array([[0, 1, 2]]))
    rollout = simulate(scene(cloth=cloth, table=None, material=CLOTH.model_copy(update={"air_drag": 0.0})))
    assert rollout.positions[-1, :, 2] == pytest.approx(-0.5 * 9.81 * rollout.times[-1] ** 2, rel=1e-2)


@pytest.mark.parametrize(
    "changes",
    [{"times": np.array(0.0)}, {"positions": np.zeros((3, 3))}, {"info": np.array("[]")}, {"info": np.array("{")}],
)
def test_a_rollout_of_another_form_is_refused(tmp_path: Path, changes: dict[str, np.ndarray]) -> None:
    arrays = {"times": np.zeros(1), "positions": np.zeros((1, 3, 3)), "faces": np.array([[0, 1, 2]])}
    np.savez(tmp_path / "r.npz", allow_pickle=False, **{**arrays, "info": np.array("{}"), **changes})
    with pytest.raises(InputError, match="not a rollout"):
        Rollout.load(tmp_path / "r.npz")


@pytest.mark.parametrize("text", ['{"vertices": 1' + "0" * 5000 + "}", "[" * 100_000, '{"cloth": "\ud800"}'])
def test_a_scene_file_with_odd_content_is_refused_in_a_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "s.json").write_text(text, encoding="utf-8", errors="surrogatepass")
    with pytest.raises(InputError, match=r"s\.json: "):
        Scene.load(tmp_path / "s.json")


@pytest.mark.parametrize("text", ["x = 1" + "0" * 5000, "x = " + "[" * 100_000, "x = "])
def test_a_material_file_with_odd_content_is_refused_in_a_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "m.toml").write_text(text)
    with pytest.raises(InputError, match=r"m\.toml: is not valid TOML"):
        load_material(tmp_path / "m.toml")


def test_a_vertex_beyond_all_numbers_is_refused() -> None:
    with pytest.raises(ValueError, match="must be a list of"):
        Scene.model_validate(changed("cloth.vertices", [[10**400, 0, 0], [1, 0, 0], [0, 1, 0]]))


def test_the_ranges_in_the_docs_are_those_of_the_code() -> None:
    parts: dict[str, type[BaseModel]] = {"material.": Material, "table.": Table, "": Scene}
    rows = []
    for prefix, model in parts.items():
        for name, field in model.model_fields.items():
            limits = {type(limit).__name__: limit for limit in field.metadata}
            if "Le" in limits:
                low = f"{limits['Ge'].ge:g}" if "Ge" in limits else f"above {limits['Gt'].gt:g}"
                rows.append(f"| {prefix}{name} | {low} | {limits['Le'].le:g} |")
    page = (Path(__file__).parents[1] / "docs" / "reference" / "scene-and-rollout.md").read_text()
    assert [line for line in page.splitlines() if line in rows] == rows and len(rows) == 26
