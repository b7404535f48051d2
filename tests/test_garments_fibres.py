"""The direction of the warp in each panel of a garment, from its pattern to the scenes that are simulated."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tatamu.calibration.elongation import Elongation, Grasp
from tatamu.folding.manipulation import bezier_manipulation
from tatamu.folding.task import make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.garments import make_garment
from tatamu.garments.worn import along_v
from tatamu.simulation.simulators import simulate
from tests.worn import worn_shirt_obj

WARP, WEFT = 400.0, 60.0


def test_a_set_in_sleeve_has_its_warp_along_the_sleeve_and_the_body_along_its_length() -> None:
    shirt = make_garment("tshirt", size=(0.8, 0.7))
    assert shirt.fibre is not None
    middle = shirt.unstrained[shirt.faces].mean(axis=1)
    outer = np.abs(middle[:, 1]) > 0.9 * np.abs(middle[:, 1]).max()
    (along,) = np.unique(shirt.fibre[outer & (middle[:, 1] > 0.0)].round(9), axis=0)
    hem = np.mean([shirt.vertices[shirt.edges["left_sleeve"]][k, :2] for k in (0, -1)], axis=0)
    inner = shirt.vertices[np.argmin(np.linalg.norm(shirt.vertices[:, :2] - (hem - 0.15 * along[:2]), axis=1)), :2]
    assert np.linalg.norm(inner - (hem - 0.15 * along[:2])) < 0.02, "the sleeve runs back to the body"
    assert along[1] > 0.8
    assert (shirt.fibre[np.abs(middle[:, 1]) < 0.1] == [1.0, 0.0, 0.0]).all()
    assert shirt.fibre[outer & (middle[:, 1] < 0.0)][0] == pytest.approx(along * [1.0, -1.0, 1.0])


def test_a_scene_of_a_fold_has_the_directions_of_its_garment() -> None:
    task = make_task("tshirt", spacing=0.04)
    grasps = int(task.fold.left[0]), int(task.fold.right[0])
    manipulation = bezier_manipulation(task.fold, grasps, 0.05, 0.1, 0.2, 0.1)
    fibre = scene_of(task.fold, manipulation).cloth.fibre
    assert fibre is not None and (fibre == task.fold.garment.fibre).all()


def test_plus_v_of_a_pattern_is_found_in_triangles_however_they_are_turned() -> None:
    uv = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]])
    flat = np.concatenate([uv, np.zeros((2, 3, 1))], axis=2)
    angle = np.radians(30.0)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    assert along_v(uv, 0.3 * flat @ turn.T) == pytest.approx(np.tile(turn @ [0.0, 1.0, 0.0], (2, 1)))


@pytest.mark.parametrize("remesh", [False, True])
def test_a_uv_map_tells_the_warp_of_each_panel(tmp_path: Path, remesh: bool) -> None:
    """The map of this shirt has its panels lying: v runs across its length."""
    worn_shirt_obj(tmp_path, unit=1.0, uv=True)
    (tmp_path / "shirt.toml").write_text(
        '[garment]\nmesh = "worn.obj"\n' + ("remesh = true\nspacing = 0.016\n" if remesh else "")
    )
    shirt = make_garment(str(tmp_path / "shirt.toml"))
    assert shirt.fibre is not None and len(shirt.fibre) == len(shirt.faces)
    across = np.abs(shirt.fibre[:, 1])
    assert np.median(across) > 0.99 and np.quantile(across, 0.05) > 0.9


def test_a_garment_hangs_by_its_own_directions() -> None:
    towel = make_garment("towel", size=(0.2, 0.3), spacing=0.03)
    turned = replace(towel, fibre=np.array([[0.0, 1.0, 0.0]]))
    woven = {"areal_density": 0.3, "shear_stiffness": 30.0, "poisson_ratio": 0.1}
    hung = []
    for garment, warp, weft in ((towel, WARP, WEFT), (turned, WARP, WEFT), (towel, WEFT, WARP)):
        material = towel.material.model_copy(
            update={**woven, "stretch_stiffness": warp, "stretch_stiffness_weft": weft}
        )
        test = Elongation(garment, (Grasp(edge="bottom"),))
        hung.append(test.reading(simulate(test.scene(material))))
    assert hung[1] == pytest.approx(hung[2], rel=1e-3)
    assert hung[1] > 3.0 * hung[0]
