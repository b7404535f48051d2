"""The paper's experiment again: its numbers, its studies, its claims."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from studies.paper import Choices, Study, run
from studies.paper.__main__ import app
from studies.paper.claims import claims, separation
from studies.paper.li import Li
from studies.paper.page import TABLES, page

from tatamu.base.errors import InputError
from tatamu.cli.program import run as run_program
from tatamu.folding.baselines import li_2015
from tatamu.folding.score import score
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.blender.recipe import joined, written
from tatamu.simulation.material import PRESETS, load_material
from tatamu.simulation.mesh.topology import Topology
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth
from tatamu.simulation.simulators import simulate
from tatamu.study.loop import Progress
from tatamu.study.result import Result
from tests.fabricated import write_fold
from tests.scenes import scene, sheet
from tests.small_studies import towel

PAPER = {
    "tshirt": (0.3, 15.0, 5.0, 25.0, 80.0, 6.0, 15.0),
    "towel": (0.3, 1.5, 5.0, 6.0, 55.0, 20.0, 30.0),
    "trousers": (3.0, 10.0, 5.0, 10.0, 80.0, 10.0, 10.0),
}
"""Tables I and II, read down the columns, without the multiplier."""


@pytest.mark.parametrize("garment", PAPER)
def test_presets_have_the_numbers_of_the_paper(garment: str) -> None:
    material = load_material(Path(f"paper-{garment}"))
    assert material.blender is not None
    assert tuple(material.blender[key] for _, key, _ in TABLES) == PAPER[garment]
    assert material.friction_table == pytest.approx(PAPER[garment][4] / 100)
    request = written(scene(material=material)).request
    assert request["settings"]["bending_model"] == "LINEAR"
    assert request["collider"]["settings"]["cloth_friction"] == PAPER[garment][4]
    assert (PRESETS / f"paper-{garment}.toml").is_file()


@pytest.mark.parametrize(("rate", "substeps"), [(60.0, 3), (1 / np.sqrt(1e-3), 5), (10.0, 16)])
def test_substeps_are_as_fine_as_blenders_own(rate: float, substeps: int) -> None:
    made = scene(material=load_material(Path("paper-towel")), frame_rate=rate, duration=3 / rate)
    assert written(made).request["settings"]["quality"] == substeps


def test_the_linear_model_is_given_quadrilaterals() -> None:
    strip = sheet(0.1, 0.24)
    faces = joined(strip.vertices, strip.faces)
    four = [face for face in faces if len(face) == 4]
    assert 2 * len(four) + len(faces) - len(four) == len(strip.faces)
    assert 2 * len(four) > 0.9 * len(strip.faces)
    sides = {(int(face[k]), int(face[(k + 1) % 3])) for face in strip.faces for k in range(3)}
    for face in faces:
        assert {(face[k], face[(k + 1) % len(face)]) for k in range(len(face))} <= sides, "the same side is up"
    joints = Topology(strip.faces).edges
    rows = {tuple(edge) for edge in joints.tolist() if abs(np.diff(strip.vertices[edge, 0]).item()) < 1e-9}
    kept = {tuple(sorted((face[k], face[(k + 1) % 4]))) for face in four for k in range(4)}
    assert len(rows & kept) > 0.9 * len(rows), "sides run along the rows"


def folded(where: Path, size: float = 0.0018) -> Result:
    return Result.load(write_fold(where, size=size, count=12))


def outcome(fold: Result, final: np.ndarray) -> Result:
    positions = fold.rollout.positions.copy()
    positions[-1] = final
    told = Rollout(fold.rollout.times, positions, fold.faces, fold.rollout.info, fold.rollout.extra)
    return replace(fold, rollout=told)


def lying(fold: Result, count: int) -> Result:
    """The fold with a target that leaves the last `count` vertices where they are."""
    target = fold.start + np.array([0.0, 0.0, 0.1])
    target[-count:] = fold.start[-count:]
    told = fold.rollout
    return replace(fold, rollout=Rollout(told.times, told.positions, told.faces, told.info, {"target": target}))


def test_two_peaks_are_seen_where_the_lower_side_slips(tmp_path: Path) -> None:
    fold = lying(folded(tmp_path), 50)
    noise = np.random.default_rng(0).normal(scale=5e-4, size=fold.start.shape)
    together = outcome(fold, fold.target + noise)
    assert separation(together) < 1.0
    slipped = fold.target + noise
    slipped[-50:, 0] += 0.02
    assert separation(outcome(fold, slipped)) > 10.0
    count = len(slipped) // 5
    slipped[:count, 0] += np.linspace(0.01, 0.05, count)
    assert separation(outcome(fold, slipped)) > 10.0, "the loop is a tail, not a peak"


def test_claims_count_the_seeds_that_bear_them_out(tmp_path: Path) -> None:
    fold = folded(tmp_path)
    first = fold.record.trials[0]
    assert first.score is not None
    bad = first.score.model_copy(update={"mean_vertex_distance": 0.5, "slip": 0.3})
    worst = first.model_copy(update={"objective": 50.0, "score": bad})
    better = replace(fold, record=fold.record.model_copy(update={"trials": [worst, *fold.record.trials[1:]]}))
    found = claims("towel", [Study("towel", 0, better)])
    assert [moment.after for moment in found.moments] == [1, 10, 12]
    assert found.moments[0].mean_vertex_distance == 0.5
    assert found.moved_left == 1 and found.slipped_less == 1
    good = first.score.model_copy(update={"mean_vertex_distance": 1e-4, "slip": 0.0})
    least = first.model_copy(update={"objective": 1e-3, "score": good})
    never = replace(fold, record=fold.record.model_copy(update={"trials": [least, *fold.record.trials[1:]]}))
    found = claims("towel", [Study("towel", 0, never), Study("towel", 1, better)])
    assert found.moved_left == 1 and found.slipped_less == 1 and found.seeds == 2


def test_choices_are_checked() -> None:
    for wrong, says in (
        ({"garments": ("skirt",)}, "garment"),
        ({"garments": ()}, "--garments"),
        ({"garments": ("towel", "towel")}, "--garments"),
        ({"seeds": 0}, "--seeds"),
        ({"trials": 0}, "--trials"),
        ({"simulator": "real"}, "simulator"),
        ({"spacings": {"sock": 0.02}}, "garment"),
        ({"sampler": "luck"}, "sampler"),
    ):
        with pytest.raises(InputError, match=says):
            Choices(**wrong)


SMALL = Choices(
    simulator="native",
    garments=("towel",),
    seeds=2,
    trials=2,
    sizes={"towel": (0.2, 0.34)},
    materials={"towel": "terry"},
)


def test_studies_go_on_where_they_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "terry.toml").write_text(
        "[material]\nareal_density = 0.35\nstretch_stiffness = 260.0\nbending_rigidity = 6e-5\nthickness = 0.002\n"
    )
    choices = replace(SMALL, materials={"towel": str(tmp_path / "terry.toml")})

    def stop(garment: str, seed: int, progress: object) -> None:
        if seed == 1 and getattr(progress, "done", 0) == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(choices, tmp_path / "out", stop)
    begun: list[tuple[int, int]] = []

    def note(garment: str, seed: int, now: Progress) -> None:
        if now.stage == "trials":
            begun.append((seed, now.done))

    studies = run(choices, tmp_path / "out", note)
    assert begun == [(1, 1), (1, 2)], "the finished study is not run again, the other goes on"
    assert [study.seed for study in studies] == [0, 1]
    assert studies[0].fold.record.grasps == "continuous"
    html = page(choices, studies)
    for part in ("Fig. 5", "Fig. 6", "Tables I and II", "moves left", " of 2<"):
        assert part in html


def test_wrong_words_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words, says in (
        (["--size", "0.2x0.3"], "--size"),
        (["--spacing", "towel=fine"], "--spacing"),
        (["--garments", "skirt"], "garment"),
        (["--material", "towel=none"], "none"),
    ):
        with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as stopped:
            patch.setattr("sys.argv", ["paper", "--simulator", "native", "--out", str(tmp_path), *words])
            run_program(app, "paper")
        assert stopped.value.code == 2
        error = capsys.readouterr().err
        assert says in error and error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_the_method_of_li_starts_with_their_curve_at_the_corners_and_leads_down() -> None:
    task = towel()
    method = Li(task, 12)
    method.search()
    objectives = [objective for objective, _ in method.done.values()]
    first = method.parameters(np.array(next(iter(method.done))))
    assert len(objectives) == 12 and first["g1"] == first["g2"] == 0
    made = li_2015(task.fold)
    reached = score(task.fold, made.trajectory_length, simulate(scene_of(task.fold, made)).positions[-1])
    assert objectives[0] == pytest.approx(reached.objective)
    assert min(objectives[5:]) < min(objectives[:5])


def test_cloth_in_blender_starts_with_as_many_vertices(tmp_path: Path) -> None:
    strip = sheet(0.1, 0.24)
    made = scene(cloth=Cloth(vertices=strip.vertices, faces=strip.faces), material=load_material(Path("paper-towel")))
    request = written(made).request
    assert len(request["vertices"]) == len(strip.vertices)
    assert {vertex for face in request["faces"] for vertex in face} == set(range(len(strip.vertices)))
    json.dumps(request, allow_nan=False)


def test_a_plan_of_several_steps_is_refused() -> None:
    with pytest.raises(InputError, match="trousers=half has 2 steps"):
        Choices(garments=("trousers",), folds={"trousers": "half"}).task("trousers")
