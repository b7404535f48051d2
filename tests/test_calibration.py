"""Calibration: readings in, the cloth that gives them out; and what is said when they cannot tell."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import Material, Rollout, Scene, simulate
from tatamu.base.errors import InputError, SimulationError, TatamuError
from tatamu.base.files import validated
from tatamu.calibration import Measurements, advice_on, calibrate, laboratory
from tatamu.calibration.advice import best_repeat
from tatamu.calibration.elongation import Elongation, Grasp
from tatamu.calibration.friction import RESOLUTION, SLIDING, Slope, threshold
from tatamu.calibration.match import match
from tatamu.calibration.page import page
from tatamu.calibration.parameters import PARAMETERS
from tatamu.calibration.readings import Reading, uncertainty
from tatamu.calibration.result import Calibration
from tatamu.calibration.sag import Sag
from tatamu.calibration.uncertainty import Sensitivity, Slopes, contributions, slopes
from tatamu.garments import make_garment
from tatamu.simulation.heavy_strip import tip
from tatamu.simulation.material import GRAVITY, load_material
from tests.browser import Phone

SIZE = (0.2, 0.6)
HIDDEN = Material(areal_density=0.24, stretch_stiffness=45.0, bending_rigidity=4e-5, thickness=0.002)
FREE = 0.05


@cache
def truth() -> tuple[float, float]:
    """L1 - L2 and sag of the hidden material [m], simulated on finer meshes than calibration's, to 0.1 mm."""
    hung = Elongation(make_garment("towel", SIZE, HIDDEN, 0.014), [Grasp(edge="bottom")])
    strip = Sag(FREE, FREE / 16)
    longer, sag = (test.reading(simulate(test.scene(HIDDEN))) for test in (hung, strip))
    return round(longer, 4), round(sag, 4)


def readings(**changes: Any) -> dict[str, Any]:
    """Readings of the hidden material; `table__field` changes one, `table` = None leaves a test out."""
    longer, sag = truth()
    whole: dict[str, Any] = {
        "garment": {"name": "towel", "size": list(SIZE), "mass": HIDDEN.areal_density * SIZE[0] * SIZE[1]},
        "elongation": {"grasps": [{"edge": "bottom"}], "L1": SIZE[1] + longer, "L2": SIZE[1]},
        "friction": {"L_t": 0.6, "H_s": 0.25},
        "sag": {"edge": "bottom", "free_length": FREE, "sag": sag},
    }
    for key, value in changes.items():
        table, _, field = key.partition("__")
        if field:
            whole[table] = {**whole[table], field: value}
        elif value is None:
            whole.pop(table)
        else:
            whole[table] = value
    return whole


UNREAD = ("air_added_mass", "air_drag_quadratic", "shear_stiffness", "bending_hysteresis")
"""Parameters of tests that the readings here do not have."""


def measured(**changes: Any) -> Measurements:
    return validated(Measurements, readings(**changes), "readings.toml")


@pytest.fixture(scope="module")
def found() -> Calibration:
    return calibrate(measured())


def test_readings_of_a_hidden_material_give_it_back(found: Calibration) -> None:
    material = found.material
    assert material.areal_density == pytest.approx(HIDDEN.areal_density, rel=1e-6)
    assert material.stretch_stiffness == pytest.approx(HIDDEN.stretch_stiffness, rel=0.02)
    assert material.bending_rigidity == pytest.approx(HIDDEN.bending_rigidity, rel=0.03)
    assert np.degrees(np.arctan(material.friction_table)) == pytest.approx(np.degrees(np.arcsin(0.25 / 0.6)), abs=0.2)
    assert found.unsettled < 5e-5


def test_the_simulator_gives_the_readings_again(found: Calibration) -> None:
    given = measured().readings()
    hung, strip = (found.setup.tests[name] for name in ("elongation", "sag"))
    assert isinstance(hung, Elongation) and isinstance(strip, Sag)
    longer = hung.reading(simulate(hung.scene(found.material)))
    assert longer == pytest.approx(given["L1"].value - given["L2"].value, abs=5e-5)
    assert strip.reading(simulate(strip.scene(found.material))) == pytest.approx(given["sag"].value, abs=5e-5)


def test_the_file_is_a_material_with_its_uncertainties(found: Calibration, tmp_path: Path) -> None:
    found.save(tmp_path / "mine.toml")
    assert load_material(tmp_path / "mine.toml") == found.material
    written = tomllib.loads((tmp_path / "mine.toml").read_text())
    assert set(written["uncertainty"]) == set(PARAMETERS) - {"compression", *UNREAD}
    matrix = np.array(written["correlation"]["matrix"])
    assert np.allclose(matrix, matrix.T) and np.allclose(np.diag(matrix), 1.0)
    assert np.linalg.eigvalsh(matrix).min() > -1e-3
    assert {fit["test"] for fit in written["fit"]} == {"elongation", "sag", "friction"}


def test_the_page_shows_three_fits(found: Calibration, phone: Phone) -> None:
    html = page(found)
    phone(html)
    assert html.count("<svg xmlns") == 3
    assert all(word in html for word in ("Elongation", "Sag", "Friction", "Most would be gained"))


def test_one_more_millimetre_moves_the_parameters_as_stated(found: Calibration) -> None:
    """The delta method against calibrating once more, a standard uncertainty away."""
    given = readings()
    for table, name in (("elongation", "L1"), ("sag", "sag"), ("sag", "free_length")):
        step = 2e-4  # small, where the relation is straight
        moved = calibrate(measured(**{f"{table}__{name}": given[table][name] + step}, friction=None)).material
        for place, field in ((1, "stretch_stiffness"), (2, "bending_rigidity")):
            stated = found.contributions[name][place] * step / found.readings[name].uncertainty
            got = np.log(getattr(moved, field) / getattr(found.material, field))
            assert got == pytest.approx(stated, abs=0.004 + 0.1 * abs(stated)), (name, field)


def test_contributions_solve_what_they_say() -> None:
    """Against brute force on a closed form that has the dimensions of the tests."""

    def lengths(logs: np.ndarray, size: float, free: float) -> np.ndarray:
        density, stretch, bending = np.exp(logs)
        a, b = stretch / (density * GRAVITY * size), bending / (density * GRAVITY * size**3)
        c, d = stretch / (density * GRAVITY * free), bending / (density * GRAVITY * free**3)
        return np.array([size * (0.5 / a + 0.02 / (1 + b)), free / (1 + 8 * d + 0.1 / c)])

    logs, size, free = np.log([0.3, 60.0, 5e-5]), 0.8, 0.06
    base, step = lengths(logs, size, free), 1e-6
    slopes = [
        Slopes(base[k], *((lengths(logs + step * np.eye(3)[j], size, free)[k] - base[k]) / step for j in (1, 2)))
        for k in (0, 1)
    ]
    values = {"mass": 0.1, "length": size, "L1": 0.81, "free_length": free, "sag": base[1]}
    told = contributions(
        {name: Reading(value, 1e-6 * value) for name, value in values.items()},
        [Sensitivity(Elongation, 1.0, slopes[0]), Sensitivity(Sag, 1.0, slopes[1])],
        later=[],
    )
    for name, value in values.items():
        change = 1e-6 * value
        density = {"mass": 1e-6, "length": -1e-6}.get(name, 0.0)
        wanted = base + np.array([change if name == "L1" else 0.0, change if name == "sag" else 0.0])
        bigger = size + (change if name == "length" else 0.0), free + (change if name == "free_length" else 0.0)
        jacobian = np.array([(lengths(logs + step * np.eye(3)[j], size, free) - base) / step for j in (1, 2)]).T
        moved = np.linalg.solve(jacobian, wanted - lengths(logs + density * np.eye(3)[0], *bigger))
        assert told[name][:3] == pytest.approx([density, *moved], rel=1e-3, abs=1e-9), name


def test_chance_in_a_simulated_reading_is_uncertainty_as_an_error_of_reading_it_is() -> None:
    along = Slopes(0.05, stretch=-0.002, bending=-0.01)
    by_error = contributions({"sag": Reading(0.05, 4e-4)}, [Sensitivity(Sag, 1.0, along)], later=[])
    by_chance = contributions({"sag": Reading(0.05, 0.0)}, [Sensitivity(Sag, 1.0, along, 4e-4)], later=[])
    assert "chance" not in by_error
    assert by_chance["chance"] == pytest.approx(by_error["sag"])
    assert not by_chance["sag"].any()


@pytest.mark.parametrize(
    ("changes", "bound", "said"),
    [
        ({"sag__sag": 0.0488}, "at most", "hangs straight down"),
        ({"sag__sag": 0.001}, "at least", "stands out level"),
        ({"elongation__L1": 0.6005}, "at least", "which is enough for folding"),
    ],
)
def test_a_reading_that_cannot_tell_gives_a_bound_and_says_what_would(
    changes: dict[str, float], bound: str, said: str
) -> None:
    only = {"elongation": None} if "sag__sag" in changes else {"sag": None}
    result = calibrate(measured(**changes, friction=None, **only))
    (fit,) = result.fits
    assert fit.bound == bound
    assert fit.parameter not in result.known and fit.parameter not in result.to_toml()["uncertainty"]
    assert any(said in text for text in advice_on(result))
    limit = getattr(result.material, fit.parameter)
    assert limit < 4e-6 if bound == "at most" else limit > (2e-4 if fit.test == "sag" else 200.0)


@pytest.mark.parametrize(("longest", "L1", "bound"), [((0.0, 0.1), 0.75, "at most"), ((0.02, 1.0), 0.605, "at least")])
def test_a_reading_that_the_simulator_does_not_come_to_is_a_bound(
    monkeypatch: pytest.MonkeyPatch, longest: tuple[float, float], L1: float, bound: str
) -> None:
    honest = Elongation.reading
    monkeypatch.setattr(Elongation, "reading", lambda *given: float(np.clip(honest(*given), *longest)))
    result = calibrate(measured(elongation__L1=L1, friction=None, sag=None))
    (fit,) = result.fits
    assert fit.bound == bound and not {"stretch_stiffness", "bending_rigidity"} & set(result.known)
    assert result.to_toml()["bound"] == {"stretch_stiffness": bound}
    (said,) = (text for text in advice_on(result) if text.startswith("elongation"))
    assert f"so Y is {bound}" in said and "Is the reading right?" in said


def test_a_limp_cloth_is_told_the_length_or_the_loop_that_would_tell() -> None:
    said = advice_on(calibrate(measured(sag__sag=0.0455, errors={"length": 0.003}, friction=None, elongation=None)))
    assert any("free length of about" in text for text in said)
    said = advice_on(calibrate(measured(sag__sag=0.049, friction=None, elongation=None)))
    assert any("height of the loop" in text for text in said)


@pytest.mark.parametrize(
    ("often", "worth"), [("elongation__L1 elongation__L2", ("free_length",)), ("sag__free_length", ("L1", "L2"))]
)
def test_the_reading_worth_repeating_is_the_one_that_brings_most(often: str, worth: tuple[str, ...]) -> None:
    given = readings()
    repeats = {key: [given[key.split("__")[0]][key.split("__")[1]]] * 50 for key in often.split()}
    repeated = best_repeat(calibrate(measured(friction=None, **repeats)))
    assert repeated is not None and repeated[0] in worth
    assert all(after < before for _, before, after in repeated[1])


def test_what_is_not_measured_is_said_and_kept() -> None:
    result = calibrate(measured(elongation=None, sag=None, garment__material="denim", garment__thickness=0.0009))
    denim = load_material(Path("denim"))
    assert result.material.stretch_stiffness == denim.stretch_stiffness
    assert result.material.thickness == 0.0009
    assert {"stretch_stiffness", "bending_rigidity"} <= set(result.assumed)
    assert result.known == ("areal_density", "friction_table")


def test_the_same_readings_give_the_same_file(found: Calibration) -> None:
    assert calibrate(measured()).to_toml() == found.to_toml()


def test_a_mass_that_no_fabric_has_is_refused() -> None:
    with pytest.raises(InputError, match=r"mass: must be 0.02 to 5 kg per m² .*\(0\.0005 kg on"):
        calibrate(measured(garment__mass=0.0005))


# --- each test on its own


@pytest.mark.parametrize("gamma", [1.0, 3.0, 10.0, 30.0])
def test_sag_is_that_of_the_heavy_elastica_on_any_mesh(gamma: float) -> None:
    rigidity = HIDDEN.areal_density * GRAVITY * FREE**3 / gamma
    material = HIDDEN.model_copy(update={"bending_rigidity": rigidity, "stretch_stiffness": 300.0})
    got = [test.reading(simulate(test.scene(material))) for test in (Sag(FREE), Sag(FREE, FREE / 8))]
    assert got[0] == pytest.approx(FREE * tip(gamma)[1], rel=0.015)
    assert got[1] == pytest.approx(got[0], rel=0.02)


def test_a_towel_hangs_longer_by_the_textbooks_amount() -> None:
    free = HIDDEN.model_copy(update={"poisson_ratio": 0.0, "stretch_stiffness": 100.0})  # else the grip stiffens it
    test = Elongation(make_garment("towel", SIZE, free, 0.02), [Grasp(edge="bottom")])
    assert test.length == pytest.approx(SIZE[1])
    got = test.reading(simulate(test.scene(free)))
    assert got == pytest.approx(test.guess(1.0, free) / free.stretch_stiffness, rel=0.015)


@pytest.mark.parametrize(("name", "edges"), [("tshirt", ["left_shoulder", "right_shoulder"]), ("trousers", ["waist"])])
def test_a_sewn_garment_hangs_by_its_own_shape(name: str, edges: list[str]) -> None:
    garment = make_garment(name, spacing=0.03)
    test = Elongation(garment, [Grasp(edge=edge) for edge in edges])
    soft = garment.material.model_copy(update={"stretch_stiffness": garment.material.stretch_stiffness / 2})
    stiff, twice = (test.reading(simulate(test.scene(material))) for material in (garment.material, soft))
    assert stiff > 1e-3
    assert twice == pytest.approx(2 * stiff, rel=0.05)


def test_a_length_of_another_garment_is_refused() -> None:
    other = {"elongation__L1": 2 * SIZE[1] + 0.01, "elongation__L2": 2 * SIZE[1]}
    with pytest.raises(InputError, match=r"L2 .* must be within 25 % of"):
        calibrate(measured(**other))


def test_an_edge_that_is_not_there_is_named() -> None:
    with pytest.raises(InputError, match=r"edge: must be one of .*bottom.*, given 'collar'"):
        calibrate(measured(elongation__grasps=[{"edge": "collar"}]))
    said = (
        r"sag: free_length \(0\.19 m\) must be at most 0\.13 m for edge bottom, which is 0\.20 m long; choose a longer"
    )
    with pytest.raises(InputError, match=said):
        calibrate(measured(sag__free_length=0.19, sag__sag=0.1))


def test_a_pinch_holds_only_its_part_of_the_edge() -> None:
    garment = make_garment("towel", SIZE, HIDDEN, 0.02)
    whole = Elongation(garment, [Grasp(edge="bottom")]).held[0]
    pinch = Elongation(garment, [Grasp(edge="bottom", at=0.0, width=0.03)]).held[0]
    assert 2 <= len(pinch) < len(whole) / 2
    assert set(pinch) < set(whole)


@pytest.mark.parametrize("true", [0.5, 0.30, 0.8])
def test_sliding_is_found_from_a_wrong_guess(true: float) -> None:
    sliding = threshold(lambda coefficient: 1.0 if coefficient < true else 0.0, 0.5)
    assert sliding.slides < true <= sliding.sticks
    assert sliding.sticks - sliding.slides <= RESOLUTION
    assert all((speed > SLIDING) == (coefficient < true) for coefficient, speed in sliding.samples)


@pytest.mark.parametrize(("speed", "bound"), [(0.0, "at most"), (1.0, "at least")])
def test_a_cloth_that_always_slides_or_never_bounds_friction(speed: float, bound: str) -> None:
    sliding = threshold(lambda coefficient: speed, 0.5)
    assert sliding.bound == bound and sliding.coefficient == 0.5
    assert len(sliding.samples) < 12


def test_a_simulator_that_cannot_hold_the_cloth_is_said_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Slope, "speed", lambda self, rollout: 1.0)
    result = calibrate(measured(elongation=None, sag=None))
    assert "friction_table" not in result.known
    assert any("whatever the coefficient" in text for text in advice_on(result))


def test_the_simulated_board_agrees_with_the_textbook() -> None:
    slope = Slope(0.5)
    for factor, slides in ((0.99, True), (1.01, False)):
        material = HIDDEN.model_copy(update={"friction_table": factor * slope.textbook})
        assert (slope.speed(simulate(slope.scene(material))) > SLIDING) == slides


# --- the search


def test_a_match_is_found_in_few_simulations() -> None:
    count = 0

    def reading(parameter: float) -> float:
        nonlocal count
        count += 1
        return 0.1 / (1.0 + parameter)

    result = match(reading, 0.02, 0.1, (1e-3, 1e3), 1e-6, lambda value: float(np.log(value)))
    assert result.reached and result.parameter == pytest.approx(4.0, rel=1e-3)
    assert count <= 8


def test_a_match_out_of_reach_ends_at_the_range() -> None:
    result = match(lambda p: 0.1 / (1.0 + p), 0.2, 1.0, (1e-3, 1e3), 1e-6, lambda value: float(np.log(value)))
    assert not result.reached and result.parameter == pytest.approx(1e-3)


def test_a_match_survives_a_start_that_is_too_soft() -> None:
    result = match(lambda p: np.inf if p < 2.0 else 1.0 / p, 0.25, 0.1, (1e-3, 1e3), 1e-6, lambda v: float(np.log(v)))
    assert result.reached and result.parameter == pytest.approx(4.0, rel=1e-4)


def test_repeats_lower_the_uncertainty_and_their_scatter_raises_it() -> None:
    assert uncertainty((1.0,), 0.001) == 0.001
    assert uncertainty((1.0,) * 4, 0.001) == pytest.approx(0.0005)
    assert uncertainty((0.99, 1.0, 1.01), 0.001) == pytest.approx(0.01 / np.sqrt(3))


def test_a_scene_that_has_not_settled_is_run_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    durations: list[float] = []

    def slow(scene: Scene, simulator: str) -> Rollout:
        durations.append(scene.duration)
        times = np.arange(scene.frames) / scene.frame_rate
        fall = 0.02 * (1.0 - np.exp(-2.0 * times))
        positions = scene.cloth.vertices - fall[:, None, None] * [0, 0, 1]
        return Rollout(times, positions, scene.cloth.faces, {})

    monkeypatch.setattr(laboratory, "simulate", slow)
    lab = laboratory.Laboratory("native")
    assert lab.reading(Sag(FREE), HIDDEN) == pytest.approx(0.02, abs=1e-4)
    assert durations == sorted(set(durations)) and len(durations) > 1
    lab.reading(Sag(FREE), HIDDEN)
    assert len(durations) == lab.simulations  # the second reading was remembered


def test_a_scene_that_never_settles_does_not_grow_from_reading_to_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    durations: list[float] = []

    def creeping(scene: Scene, simulator: str) -> Rollout:
        durations.append(scene.duration)
        times = np.arange(scene.frames) / scene.frame_rate
        return Rollout(times, scene.cloth.vertices - 0.01 * times[:, None, None] * [0, 0, 1], scene.cloth.faces, {})

    monkeypatch.setattr(laboratory, "simulate", creeping)
    lab = laboratory.Laboratory("native")
    for stiffness in (100.0, 200.0, 300.0):
        lab.reading(Sag(FREE), HIDDEN.model_copy(update={"stretch_stiffness": stiffness}))
    assert max(durations) <= lab.options.longest * min(durations) and lab.simulations == len(durations) == 6
    assert lab.unsettled > lab.options.settled


def test_cloth_that_does_not_come_to_rest_is_said(found: Calibration) -> None:
    assert not any("come to rest" in text for text in advice_on(found))
    creeping = advice_on(replace(found, unsettled=0.002))
    assert any(
        "the cloth in native does not come to rest: a reading still changed by 2.0 mm" in text for text in creeping
    )


def test_a_cloth_too_soft_for_the_simulator_reads_as_infinitely_long(monkeypatch: pytest.MonkeyPatch) -> None:
    def give_up(scene: Scene, simulator: str) -> Rollout:
        raise SimulationError("stretched")

    monkeypatch.setattr(laboratory, "simulate", give_up)
    assert laboratory.Laboratory("native").reading(Sag(FREE), HIDDEN) == np.inf
    with pytest.raises(SimulationError, match="sag: native gave up: stretched"):
        calibrate(measured(elongation=None, friction=None))


def test_thick_cloth_on_a_short_free_length_sags_like_thin_cloth() -> None:
    strip = Sag(0.03, 0.03 / 18)
    thick, thin = (HIDDEN.model_copy(update={"thickness": t, "bending_rigidity": 1e-5}) for t in (0.004, 0.0001))
    assert strip.reading(simulate(strip.scene(thick))) == pytest.approx(strip.reading(simulate(strip.scene(thin))))


def test_a_slope_beside_what_the_simulator_refuses_is_taken_from_one_side() -> None:
    found = slopes(lambda stretch, bending: np.inf if stretch < 0.0 else 3.0 * stretch + 2.0 * bending, (0.0, 0.0), 0.1)
    assert (found.stretch, found.bending) == pytest.approx((3.0, 2.0))
    with pytest.raises(TatamuError, match="softer and stiffer cloth fail"):
        slopes(lambda stretch, bending: np.inf if stretch else bending, (0.0, 0.0), 0.1)
