"""Tests on real cloth: readings of known shapes and swings, fabricated measurements, files that are wrong."""

from __future__ import annotations

import gzip
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from studies.real_cloth import bench as benches
from studies.real_cloth import notes
from studies.real_cloth.__main__ import app
from studies.real_cloth.alignment import UNMOVED, Displacement, Pairs
from studies.real_cloth.bench import Bench, Experiment, Values
from studies.real_cloth.fabric import Fabric
from studies.real_cloth.fitted_air import START, fit
from studies.real_cloth.fitted_drape import DENSITY, TYPICAL
from studies.real_cloth.hem import Hem, WavyDrapemeter
from studies.real_cloth.leeds import MODELS, Leeds, MeasuredHems
from studies.real_cloth.matsudaira import FILE, NUMBERS, Matsudaira, models
from studies.real_cloth.page import page
from studies.real_cloth.pendulum import AirLaw, plate_nodes, plate_swing
from studies.real_cloth.recording import BEFORE, Recording, load_recordings
from studies.real_cloth.study import load, run
from typer.testing import CliRunner

from tatamu.base.errors import InputError
from tatamu.calibration.instruments.drapemeter import Drapemeter
from tatamu.calibration.instruments.oscillation import swings
from tatamu.simulation.material import Material

ANGLES = 2.0 * np.pi * np.arange(360) / 360
STIFF = "S,stiff,3.0,0.1,20.0,0.5,97.0,4"
"""A fabric too stiff to drape much, which simulates in a second."""


def waved(mean: float, folds: int, amplitude: float, ellipse: float = 0.0) -> Hem:
    return Hem(mean + amplitude * np.cos(folds * ANGLES + 0.3) + ellipse * np.cos(2 * ANGLES))


def write_fabrics(folder: Path, rows: str = STIFF) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / FILE).write_text(f"# fabricated\nid,fabric,{','.join(NUMBERS)}\n{rows}\n")
    return folder


def test_an_outline_tells_what_it_was_made_of() -> None:
    outline = waved(0.12, 7, 0.01, 0.004)
    assert outline.nodes == 7
    assert outline.amplitude == pytest.approx(0.01, rel=0.06)
    assert outline.harmonic(2) == pytest.approx(0.004, rel=1e-6)
    assert outline.wavelength == pytest.approx(2.0 * np.pi * 0.12 / 7)
    assert waved(0.12, 7, 0.001).nodes == 0  # below the least prominence
    assert waved(0.15, 0, 0.0).drape_coefficient(0.15, 0.09) == pytest.approx(1.0, abs=1e-3)
    assert waved(0.09, 0, 0.0).drape_coefficient(0.15, 0.09) == pytest.approx(0.0, abs=1e-3)


def test_an_outline_of_a_mesh_is_its_silhouette_even_where_the_hem_is_tucked_under() -> None:
    points, faces = Drapemeter(0.1, 0.05, 0.01).mesh
    radii = np.hypot(*points.T)
    tucked = points * np.where(radii > 0.095, 0.8, 1.0)[:, None]
    reach = Hem.of(np.column_stack([tucked, 0.0 * radii]), faces, np.zeros(2)).radii
    assert reach.min() > 0.08 and reach.max() < 0.0955


def test_a_swing_tells_period_and_decrement_though_its_rest_is_off() -> None:
    times = np.arange(0.0, 8.0, 0.1)
    signal = 0.05 * np.exp(-0.4 / 1.1 * times) * np.cos(2.0 * np.pi * times / 1.1) + 0.0005
    found = [each for each in swings(times, signal, 0.004) if np.isfinite(each.decrement)]
    assert np.median([each.period for each in found]) == pytest.approx(1.1, rel=0.01)
    assert np.median([each.decrement for each in found]) == pytest.approx(0.4, rel=0.1)
    assert not swings(times, signal, 0.06)


def recorded(air: AirLaw) -> Recording:
    """A recording of the plate itself, whose bar is jerked across."""
    tool_times = np.arange(0.0, 9.0, 0.05)
    moved = 0.2 * np.clip((tool_times - 1.0) / 0.8, 0.0, 1.0)
    tool = np.column_stack([moved, 0.0 * moved, 0.5 + 0.0 * moved])
    still = np.tile([0.0, 0.0, 0.0, 1.0], (len(tool_times), 1))
    times = np.arange(0.5, 9.0, 0.1)
    top = np.stack([np.interp(times, tool_times, column) for column in tool.T], axis=1)
    nodes = np.zeros((len(times), 3, 3, 3))
    nodes[:] = top[:, None, None] + np.linspace(-0.15, 0.15, 3)[:, None] * [0.0, 1.0, 0.0]
    recording = Recording("made", times + 0.3, nodes, tool_times, tool, still)
    swung = plate_swing(recording, air, 0.3)
    sign = -1.0  # across a bar along y is -x
    nodes[:, 0, :, 0] += sign * swung[:, None]
    nodes[:, 0, :, 2] -= 0.3
    return Recording("made", times + 0.3, nodes, tool_times, tool, still)


def test_air_is_recovered_from_a_recording_of_the_plate() -> None:
    recording = recorded(AirLaw(0.5, 0.6, 4.0))
    assert recording.grip[0] == pytest.approx(0.3, abs=0.021)
    found = fit(
        lambda air: [plate_swing(recording, air, 0.3)], [recording], lambda numbers: AirLaw(*numbers.tolist()), START
    )
    assert found.added_mass == pytest.approx(0.5, abs=0.1)
    damped = found.linear + 0.05 * 6.0 * found.quadratic
    assert damped == pytest.approx(0.6 + 0.05 * 6.0 * 4.0, rel=0.3)


def test_a_displaced_camera_is_found_and_allowed_for() -> None:
    random = np.random.default_rng(0)
    places = random.normal(0.0, 0.1, (400, 3))
    turn = Rotation.from_rotvec([0.03, -0.02, 0.01])
    moved = Displacement(turn.as_matrix(), np.array([0.01, 0.0, -0.02]))
    seen = turn.apply(places) + moved.translation + random.normal(0.0, 0.003, places.shape)
    pairs = Pairs.from_plain(Pairs.of(places, seen).plain())
    assert pairs.distance() == pytest.approx(np.sqrt(((seen - places) ** 2).sum(axis=1).mean()), rel=1e-9)
    found = pairs.displacement()
    assert found.rotation == pytest.approx(moved.rotation, abs=3e-3)
    assert found.translation == pytest.approx(moved.translation, abs=1e-3)
    assert pairs.distance(found) == pytest.approx(0.003 * np.sqrt(3.0), rel=0.05)
    assert pairs.distance(found) < pairs.distance(pairs.translation()) < pairs.distance(UNMOVED)
    assert found.angle == pytest.approx(turn.magnitude(), rel=0.05)


def test_a_disc_too_stiff_to_drape_keeps_its_area(tmp_path: Path) -> None:
    section = Matsudaira().run(
        Matsudaira().load(write_fabrics(tmp_path / "data")), Bench("native", tmp_path / "kept", seeds=1)
    )
    line = section.tables[0].lines[0]
    assert float(line["isotropic, 254/127 mm"].split()[0]) > 80.0
    assert "reached" in section.goal


def test_what_was_simulated_is_not_simulated_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tests = load(write_fabrics(tmp_path / "data"), ["drape"])
    ticks: list[str] = []
    bench = Bench("native", tmp_path / "kept", seeds=1, tick=ticks.append)
    first = run(tests, bench)
    monkeypatch.setattr(benches, "simulate", None)
    assert notes.data(run(tests, bench), "native") == notes.data(first, "native")
    assert len(ticks) == 2 * len(models("native"))
    assert "stiff" in page(first, "native") and "stiff" in notes.page(first, "native")


STIFFER = tuple(np.geomspace(2e-5, 1e-3, 7).tolist())
"""Rigidities of a sweep [N m] whose coarse meshes are quickly made."""


class MadeUpBench(Bench):
    """Hems of a made-up law instead of a simulator's: rounder with the rigidity, more elliptic with the anisotropy."""

    def measure(self, experiments: Sequence[Experiment]) -> list[Values]:
        return [made_up(each.scene.material) for each in experiments]


def made_up(material: Material) -> Values:
    warp, weft = material.bending_rigidity, material.weft_rigidity
    outline = made_up_hem(0.5 * (warp + weft), warp / weft)
    return {"radii": outline.radii.tolist(), "area": outline.area, "area_before": outline.area}


def made_up_hem(bending: float, anisotropy: float) -> Hem:
    part = np.log(bending / STIFFER[0]) / np.log(STIFFER[-1] / STIFFER[0])
    return waved(0.1 + 0.04 * part, 7, 0.008, 0.006 * np.log(anisotropy))


def test_rigidity_and_anisotropy_of_a_weave_are_recovered_from_its_hems(tmp_path: Path) -> None:
    test = Leeds([replace(model, rigidities=STIFFER) for model in MODELS])
    hidden = [(6e-5, 1.3), (3e-4, 2.4)]
    hems = [MeasuredHems(f"{B:g}", [made_up_hem(B, anisotropy)]) for B, anisotropy in hidden]
    models, nodes, lines = (table.lines for table in test.run(hems, MadeUpBench("native", tmp_path, seeds=1)).tables)
    assert [line["nodes within 1"] for line in models] == ["2 of 2"] * len(models)
    assert all(line["typical weave"].startswith("7.0 (") for line in nodes)
    for (bending, anisotropy), line in zip(hidden, lines, strict=True):
        assert float(line["B/ρ [10⁻⁶ m⁴/s²]"]) == pytest.approx(1e6 * bending / DENSITY, rel=0.03)
        assert float(line["warp over weft"]) == pytest.approx(anisotropy, abs=0.11)
        assert line["nodes"] == "7.0, 7.0"


def test_cloth_that_is_not_flat_is_wavy_beyond_the_plate_only() -> None:
    meter = WavyDrapemeter(0.15, 0.09, 0.004, waviness=1e-3)
    height = meter.unstrained[:, 2]
    beyond = np.hypot(*meter.mesh[0].T) > 0.09 + meter.row + 0.02
    assert height[beyond].std() == pytest.approx(1e-3, rel=0.2)
    assert not height[meter.held].any()
    material = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4)
    flat = Drapemeter(0.15, 0.09, 0.004).scene(material).cloth
    assert np.array_equal(meter.scene(material).cloth.vertices, flat.vertices)
    assert flat.rest_vertices is not None and not np.signbit(flat.rest_vertices[:, 2]).any()
    assert not flat.rest_vertices[:, 2].any()


WRONG = [
    ("S,stiff,3.0,0.1,20.0,0.5,much,4", "row 1: drape_coefficient_percent: must be a finite number, given 'much'"),
    ("", "must hold at least one row"),
]


@pytest.mark.parametrize(("rows", "said"), WRONG)
def test_a_wrong_file_is_refused_in_one_line(rows: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=said):
        load(write_fabrics(tmp_path / "data", rows), ["drape"])


def test_missing_data_end_with_2_and_write_nothing(tmp_path: Path) -> None:
    for data, only in ((tmp_path / "none", "drape"), (tmp_path, "drape"), (tmp_path, "motion"), (tmp_path, "nothing")):
        arguments = ["--data", str(data), "--only", only, "--out", str(tmp_path / "out")]
        assert isinstance(CliRunner().invoke(app, arguments).exception, InputError)
    assert not (tmp_path / "out").exists()


def test_outlines_and_recordings_that_are_none_are_refused(tmp_path: Path) -> None:
    with gzip.open(tmp_path / "cusick_outlines.csv.gz", "wt") as file:
        file.write("set,fabric\ncap,1\n")
    with pytest.raises(InputError, match="must have the column r000"):
        Leeds().load(tmp_path)
    (tmp_path / "cusick_outlines.csv.gz").write_bytes(b"no gzip")
    with pytest.raises(InputError, match="cannot be read"):
        Leeds().load(tmp_path)
    np.savez(tmp_path / "motion.npz", s__a__tcp=np.zeros((9, 8)), s__a__t=np.zeros(9))
    with pytest.raises(InputError, match="s__a__mesh: must have 4 dimensions, given nothing"):
        load_recordings(tmp_path / "motion.npz", "s", ())
    with pytest.raises(InputError, match="must hold recordings"):
        load_recordings(tmp_path / "motion.npz", "other", ())
    whole = (tmp_path / "motion.npz").read_bytes()
    (tmp_path / "motion.npz").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"is not an \.npz file"):
        load_recordings(tmp_path / "motion.npz", "s", ())


def test_an_outline_of_a_curve_is_that_of_its_radii() -> None:
    outline = waved(0.12, 5, 0.02)
    curve = outline.radii[:, None] * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)]) + [0.3, -0.2]
    assert Hem.of_curve(curve, np.array([0.3, -0.2])).radii == pytest.approx(outline.radii, abs=1e-9)


def test_a_plate_without_air_swings_like_a_physical_pendulum() -> None:
    recording = recorded(AirLaw())
    clock = recording.clock
    after = clock > 2.2
    period = np.median([each.period for each in swings(clock[after], recording.swing[after], 0.004)])
    assert period == pytest.approx(2.0 * np.pi * np.sqrt(2.0 * 0.3 / (3.0 * 9.81)), rel=0.03)
    assert recording.path[0][0] == pytest.approx(clock.min() - BEFORE)


def test_recordings_count_the_same_in_the_displacement_however_many_nodes_they_have() -> None:
    few, many = np.eye(3), np.tile(np.eye(3), (100, 1))
    mean = Pairs.mean([Pairs.of(few, few + np.array([0.02, 0.0, 0.0])), Pairs.of(many, many)])
    assert mean.translation().translation == pytest.approx([0.01, 0.0, 0.0])


def test_the_nodes_of_a_plate_have_its_swing_and_its_length() -> None:
    recording = recorded(AirLaw(0.5, 0.6, 4.0))
    swing = 0.1 * np.sin(recording.clock)
    nodes = plate_nodes(recording, swing, 0.3)
    across = ((nodes[:, 0] - nodes[:, -1]) * recording.normal(recording.clock)[:, None]).sum(axis=2)
    assert across == pytest.approx(np.tile(swing[:, None], 3), abs=1e-9)
    assert np.linalg.norm(nodes[:, 0] - nodes[:, -1], axis=2) == pytest.approx(0.3)
    assert nodes[:, -1, [0, -1]] == pytest.approx(recording.corners(recording.clock))


def test_another_scene_has_another_name(tmp_path: Path) -> None:
    bench = Bench("native", tmp_path)
    material = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4)
    keys = {
        bench._key(benches.Experiment("", Drapemeter(0.1, 0.05, 0.01, seed).scene(material), what, lambda _: {}))
        for seed in (0, 1)
        for what in ("outline", "other")
    }
    assert len(keys) == 4


def test_a_weave_of_typical_anisotropy_is_the_typical_weave() -> None:
    fabric = Fabric("made up", "plain", 0.2, 1e-5)
    found, typical = fabric.weave(TYPICAL), fabric.woven
    for name in ("bending_rigidity", "bending_rigidity_weft", "bending_rigidity_bias", "shear_stiffness"):
        assert getattr(found, name) == pytest.approx(getattr(typical, name))
    stiffer = fabric.weave(3.0)
    assert stiffer.bending_rigidity == pytest.approx(3.0 * stiffer.weft_rigidity)
    assert stiffer.bending_rigidity + stiffer.weft_rigidity == pytest.approx(2e-5)
