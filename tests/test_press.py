"""Pressing: a plate, or a hand that strokes along the crease, flattens the fold when the hands have left it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import InputError
from tatamu.folding.plan import load_plan
from tatamu.folding.press import FLAT, Press
from tatamu.folding.task import Task, make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate
from tests.refusals import refusal

SMALL: dict[str, Any] = {"spacing": 0.04, "size": (0.24, 0.5)}
ARCH = {"x1": 0.05, "z1": 0.2, "x2": 0.4, "z2": 0.1, "g1": 0, "g2": 0}
STEP = '[[step]]\nline = [[0.0, -0.5], [0.0, 0.5]]\nmoves = "-x"\n'


def plan(folder: Path, press: str) -> Path:
    path = folder / "pressed.toml"
    path.write_text(f"{STEP}press = {{{press}}}\n" if press else STEP)
    return path


def task(folder: Path, press: str, **more: Any) -> Task:
    return make_task("towel", fold=str(plan(folder, press)), **{**SMALL, **more})


def scene(folder: Path, press: str, **more: Any) -> Scene:
    made = task(folder, press, **more)
    return scene_of(made.fold, made.manipulation(ARCH))


def bottom(scene: Scene, time: float) -> float:
    body = scene.bodies[-1]
    return float(body.pose(time)[0][2] - body.size[2])


def test_a_plate_comes_down_on_the_crease_when_the_hands_have_left_and_goes(tmp_path: Path) -> None:
    made = task(tmp_path, "gap = 0.005, seconds = 2.0, size = [0.05, 0.3]")
    pressed = scene_of(made.fold, made.manipulation(ARCH))
    plain = scene(tmp_path, "")
    opens = made.manipulation(ARCH).timing.opens
    body = pressed.bodies[0]
    assert body.name == "pressing plate" and body.size[:2] == [0.025, 0.15]
    assert pressed.duration > plain.duration and not plain.bodies
    times = np.linspace(0.0, pressed.duration, 200)
    heights = np.array([bottom(pressed, time) for time in times])
    assert heights[times < opens].min() > 0.5
    assert heights.min() == pytest.approx(0.005) and heights[-1] > 0.04
    assert (heights < 0.0051).sum() * times[1] == pytest.approx(2.0, abs=0.2)
    assert [hand.model_dump_json() for hand in pressed.grippers] == [hand.model_dump_json() for hand in plain.grippers]


def test_a_hand_strokes_along_the_whole_crease(tmp_path: Path) -> None:
    pressed = scene(tmp_path, 'tool = "hand", gap = 0.005')
    body = pressed.bodies[0]
    down = np.isclose(body.positions[:, 2] - body.size[2], 0.005)
    assert np.ptp(body.positions[down, 1]) == pytest.approx(0.24 - 0.03, abs=0.01)


def test_a_weight_is_the_gap_to_which_it_presses_a_bent_strip() -> None:
    material = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=2e-5, thickness=0.001)
    light, heavy = (Press(weight=w, size=(0.05, 0.2)).gap_over(material, 0.002, 0.3) for w in (1.0, 4.0))
    assert light - 0.001 == pytest.approx(FLAT * np.sqrt(2e-5 * 0.2 / 2.0)) and light > heavy
    assert heavy - 0.001 == pytest.approx(0.5 * (light - 0.001))
    assert Press(weight=1000.0).gap_over(material, 0.002, 0.3) == 0.002
    phi = np.linspace(0.0, np.pi, 200001)
    assert float(np.trapezoid(np.sqrt(np.sin(phi)), phi)) == pytest.approx(FLAT, abs=1e-3)


@pytest.mark.parametrize(
    ("press", "says"),
    [
        ("", r"pressed.toml: step\.0\.press: .*either gap or weight, given neither"),
        ("gap = 0.005, weight = 1.0", "either gap or weight, given both"),
        ("gap = -0.005", r"press\.gap"),
        ('gap = 0.005, tool = "iron"', r"press\.tool"),
        ("weight = 1.0, size = [0.0, 0.1]", r"press\.size"),
        ("weight = 1.0, seconds = 0.0", r"press\.seconds"),
        ("weight = inf", r"press\.weight"),
    ],
)
def test_a_wrong_press_is_one_line(tmp_path: Path, press: str, says: str) -> None:
    path = tmp_path / "pressed.toml"
    path.write_text(f"{STEP}press = {{{press}}}\n")
    assert re.search(says, refusal(load_plan, path))


def test_a_gap_without_room_for_the_layers_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"press\.gap: must be at least 4 mm, the thickness of all layers, given 3 mm"):
        task(tmp_path, "gap = 0.003")


def test_a_plan_with_a_press_is_read_as_it_was_written(tmp_path: Path) -> None:
    made = load_plan(plan(tmp_path, 'tool = "hand", weight = 3.0'))
    again = tmp_path / "again.toml"
    again.write_text(made.to_toml())
    assert load_plan(again).steps == made.steps


@pytest.mark.slow
def test_a_pressed_crease_stays_flatter_with_hysteresis(tmp_path: Path) -> None:
    """Friction of 50 per metre of rigidity is that of the first of four woven fabrics (presets/usual-tshirt.toml)."""

    def loop(press: str, hysteresis: float) -> float:
        """Height of the loop, mean of the last quarter of a second: elastic cloth still swings [m]."""
        material = Material(
            areal_density=0.2,
            stretch_stiffness=100.0,
            bending_rigidity=3e-5,
            bending_hysteresis=hysteresis,
            thickness=0.001,
        )
        made = task(tmp_path, press, spacing=0.012, size=(0.14, 0.4), material=material)
        curve = {"x1": 0.04, "z1": 0.16, "x2": 0.32, "z2": 0.08, "g1": 0, "g2": 0}
        last = simulate(scene_of(made.fold, made.manipulation(curve))).positions[-15:]
        return float(last[:, :, 2].max(axis=1).mean())

    press = "gap = 0.004, seconds = 0.5"
    assert loop(press, 1.5e-3) < 0.8 * loop("", 1.5e-3)
    assert loop(press, 0.0) > 0.9 * loop("", 0.0)
