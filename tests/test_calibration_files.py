"""What goes into a calibration: files, their mistakes, the template, the presets and the commands."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import tomli_w

from tatamu.base.errors import InputError
from tatamu.base.files import validated
from tatamu.calibration.measurements import instructions, load_measurements, template
from tatamu.garments import GARMENTS, make_garment
from tatamu.simulation.material import load_material, preset_names
from tatamu.simulation.presets import Preset, load_preset
from tests.commands import refused, tatamu
from tests.refusals import refusal

GOOD = """
[garment]
name = "towel"
size = [0.2, 0.4]
mass = 0.02
[elongation]
grasps = [{edge = "bottom"}]
L1 = 0.404
L2 = 0.400
[friction]
L_t = 0.6
H_s = [0.25, 0.26]
[sag]
edge = "bottom"
free_length = 0.05
sag = 0.03
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("L1 = 0.404", "L1 = 0.390", "elongation: L2 (0.4 m, lying) must be at most L1 (0.39 m, hanging)"),
        ("L1 = 0.404", "L1 = 0.7", "at most 1.5 times L2"),
        ("L1 = 0.404", "L1 = 404", "if the reading is in millimetres, write 0.404"),
        ("L1 = 0.404", "L1 = []", "elongation.L1: must contain at least one reading"),
        ("L1 = 0.404", "L1 = nan", "elongation.L1: must be a finite number of metres"),
        ("L1 = 0.404", 'L1 = "0.404 m"', "elongation.L1: must be a finite number of metres"),
        ("L1 = 0.404", "l1 = 0.404", "elongation.L1: Field required"),
        ("L1 = 0.404", "L1 = 0.404\nL3 = 1", "elongation.L3: Extra inputs are not permitted"),
        ('[{edge = "bottom"}]', '["bottom"]', "elongation.grasps.0: must be a table (an object), given 'bottom'"),
        ('edge = "bottom"}', 'edge = "bottom", at = 2}', "elongation.grasps.0.at"),
        ("H_s = [0.25, 0.26]", "H_s = 0.7", "H_s (0.7 m) must be less than L_t (0.6 m)"),
        ("H_s = [0.25, 0.26]", "H_s = 0.59", "slope below 70 degrees"),
        ("sag = 0.03", "sag = 0.06", "sag (0.06 m) must be less than free_length (0.05 m)"),
        ("free_length = 0.05\nsag = 0.03", "free_length = 0.005\nsag = 0.003", "must be at least 0.01 m"),
        ("[sag]", "[loop]\nheight = 30.0\n[sag]", "loop.height: must be at most 10 metres"),
        ("mass = 0.02", "mass = 1" + 400 * "0", "garment.mass: must be a finite number of kilograms"),
        ("mass = 0.02", "mass = -0.02", "garment.mass: must be above 0, given -0.02 kilograms"),
        ("mass = 0.02", "mass = 95", "if the reading is in grams, write 0.095"),
        ("H_s = [0.25, 0.26]", "H_s = 0", "friction.H_s: must be above 0"),
        ("sag = 0.03", "sag = 30.0", "if the reading is in millimetres, write 0.03"),
        ("size = [0.2, 0.4]", "size = [200, 400]", "if the reading is in millimetres, write 0.2"),
        ("[sag]", "[errors]\nlength = 1\n[sag]", "errors.length"),
        ("[sag]", "[sagging]", "sagging: Extra inputs"),
        ("[garment]", "[garmnt]", "garment: Field required"),
    ],
)
def test_an_impossible_reading_gets_its_sentence(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in GOOD
    file = tmp_path / "m.toml"
    file.write_text(GOOD.replace(old, new))
    message = refusal(load_measurements, file)
    assert said in message and message.startswith(f"{file}: ")


def test_readings_without_any_test_are_refused(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(GOOD.split("[elongation]")[0])
    with pytest.raises(InputError, match="at least one of the tables"):
        load_measurements(tmp_path / "m.toml")


@pytest.mark.parametrize("name", GARMENTS)
def test_a_template_asks_for_readings_and_is_right_once_filled_in(tmp_path: Path, name: str) -> None:
    file, text = tmp_path / "m.toml", template(name)
    file.write_text(text)
    with pytest.raises(InputError, match=r"garment.mass: must contain at least one reading"):
        load_measurements(file)
    for reading, value in (("mass", 0.1), ("L1", 0.504), ("L2", 0.5), ("L_t", 0.6), ("H_s", 0.3), ("sag", 0.02)):
        text = text.replace(f"{reading} = []", f"{reading} = {value}")
    file.write_text(
        text.replace("# material", "material").replace("# [loop]", "[loop]").replace("# height = []", "height = 0.03")
    )
    filled = load_measurements(file)
    assert filled.garment.material in preset_names()
    assert list(filled.entries()) == ["elongation", "friction", "sag", "loop"]


def test_calibrate_writes_a_material_and_a_page_that_learn_takes(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(GOOD)
    done = tatamu("calibrate", str(tmp_path / "m.toml"), "--out", str(tmp_path / "mine.toml"), "--spacing", "0.03")
    assert done.returncode == 0, done.stderr
    assert "stretch_stiffness" in done.stdout and "Most would be gained" in done.stdout
    assert load_material(tmp_path / "mine.toml").areal_density == pytest.approx(0.25)
    assert (tmp_path / "mine.html").read_text().startswith("<!doctype html>")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["calibrate", "FILE", "--out", "DIR/x.toml", "--simulator", "magic"], "simulator: must be one of"),
        (["calibrate", "FILE", "--out", "DIR/x.txt"], "--out: must end with .toml"),
        (["calibrate", "FILE", "--out", "DIR/x.toml", "--spacing", "nan"], "spacing: must be from"),
        (["calibrate", "none.toml", "--out", "DIR/x.toml"], "none.toml: cannot be read"),
        (["measure", "--template", "sock"], "garment: must be one of towel"),
        (["measure", "--template", "towel", "--out", "FILE"], "must be a new file"),
        (["materials", "silk"], "material: must be one of"),
    ],
)
def test_what_is_wrong_gets_one_line_and_code_2(tmp_path: Path, arguments: list[str], named: str) -> None:
    file = tmp_path / "m.toml"
    file.write_text(GOOD)
    places = {"FILE": str(file), "DIR/x.toml": str(tmp_path / "x.toml"), "DIR/x.txt": str(tmp_path / "x.txt")}
    assert named in refused(*(places.get(argument, argument) for argument in arguments))
    assert file.read_text() == GOOD and list(tmp_path.iterdir()) == [file]


def test_measure_says_what_to_do() -> None:
    done = tatamu("measure")
    assert done.returncode == 0 and done.stdout == instructions()
    assert all(word in done.stdout for word in ("L1", "L2", "L_t", "H_s", "free_length", "sag", "mass"))


@pytest.mark.parametrize("name", preset_names())
def test_a_preset_is_a_material_with_sources(name: str) -> None:
    preset = load_preset(name)
    assert load_material(Path(name)) == preset.material
    assert {"areal_density", "stretch_stiffness", "bending_rigidity"} <= set(preset.source) or preset.material.blender


def test_presets_are_listed_and_say_that_they_are_presets() -> None:
    done = tatamu("materials")
    assert done.returncode == 0 and all(name in done.stdout for name in preset_names())
    assert "other people's cloth" in done.stdout
    assert "11 oz" in tatamu("materials", "denim").stdout


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"spread": {"colour": (0, 1)}}, "fields of a material, given"),
        ({"spread": {"areal_density": (1.0, 2.0)}}, "areal_density must be within its spread, 1 to 2"),
    ],
)
def test_a_wrong_preset_is_refused(table: dict[str, Any], said: str) -> None:
    preset = load_preset("denim").model_dump()
    with pytest.raises(InputError, match=said):
        validated(Preset, {**preset, **table}, "denim.toml")


def test_a_file_goes_before_a_preset_of_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("denim").write_text("[material]\nareal_density = 0.5\nstretch_stiffness = 100\nbending_rigidity = 1e-5\n")
    assert load_material(Path("denim")).areal_density == 0.5
    with pytest.raises(InputError, match=r"must be a \.toml file or one of .*denim.*given 'no-such-cloth'"):
        load_material(Path("no-such-cloth"))


def test_a_calibrated_material_keeps_the_size_of_its_garment(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    material = tomli_w.dumps({"material": load_material(Path("terry")).model_dump()})
    file.write_text(material + '[calibration]\ngarment = "towel"\nsize = [0.30, 0.50]\n')
    assert make_garment("towel", material=file).size == (0.30, 0.50)
    assert make_garment("towel", (0.2, 0.3), file).size == (0.2, 0.3)
    assert make_garment("tshirt", material=file).size == make_garment("tshirt").size
