"""Margins on two meshes: what hangs on the mesh is simulated on the fold's own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tatamu.after.margins import Measured, measure
from tatamu.after.margins.page import page
from tatamu.after.margins.terminal import summary
from tatamu.evaluation import CoarseMesh
from tatamu.evaluation.disturbances import World
from tatamu.evaluation.robustness import MeshVerdict, Verdict
from tatamu.evaluation.robustness.meshes import SlackRange, fit_distances, select_pairs
from tatamu.folding.score import Limits
from tatamu.study.result import Result
from tests.test_margins import UP, learned

__all__ = ["learned"]

LIMITS = Limits()
Fold = Callable[[World], Verdict]


def ends(distance: float) -> Verdict:
    return Verdict(distance, 1.0)


def own(world: World) -> Verdict:
    return ends(0.0005 + 3.0 * abs(world["hands.offset.up"]))


def measured_with(monkeypatch: pytest.MonkeyPatch, folder: Path, out: Path, coarse: Fold, **options: Any) -> Measured:
    """Margins where the fold ends as these functions say on its coarse mesh and on its own."""
    monkeypatch.setattr("tatamu.after.margins.measurement.CoarseMesh", lambda: CoarseMesh(one_layer=1.4, fewest=20))

    def known(evaluator: Any, parameters: Any, world: World) -> Verdict:
        task = evaluator.task
        manipulation = task.manipulation(parameters)
        assert len(manipulation.grasps) == 2 and max(manipulation.grasps) < len(task.fold.start)
        return (coarse if task.fold.garment.spacing > 0.05 else own)(world)

    monkeypatch.setattr("tatamu.evaluation.robustness.judge.verdict_in", known)
    return measure(Result.load(folder), UP, out=out, draws=200, **options)


def test_verdicts_are_those_of_the_own_mesh_at_a_part_of_its_simulations(
    learned: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def coarse(world: World) -> Verdict:
        return ends(0.003 + 2.5 * abs(world["hands.offset.up"]) + 0.001 * (world["hands.yaw"] > 0.0))

    both = measured_with(monkeypatch, learned, tmp_path / "both", coarse).result
    fine = measured_with(monkeypatch, learned, tmp_path / "fine", coarse, fine=True).result
    assert 0.8 < fine.joint.share < 0.99 and not fine.mesh.coarser
    assert both.joint.held == fine.joint.held and both.alone == fine.alone and both.undisturbed == 0.0005
    assert both.mesh.own_simulations == both.mesh.checked and both.mesh.coarser
    assert 13 <= both.mesh.checked < 0.4 * fine.simulations and both.mesh.apart < 0.004
    spread, known = both.joint.mean_vertex_distance, fine.joint.mean_vertex_distance
    assert (spread.median, spread.q90) == pytest.approx((known.median, known.q90), abs=0.001)
    assert spread.worst == known.worst
    rough = [LIMITS.hold(coarse(world)) for world in (World({"hands.offset.up": 0.0038, "hands.yaw": 0.01}),)]
    assert rough == [False] and LIMITS.hold(own(World({"hands.offset.up": 0.0038}))), "the meshes disagree on some"


def test_meshes_that_have_nothing_in_common_end_on_the_own_one(
    learned: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = measured_with(monkeypatch, learned, tmp_path, lambda world: ends(0.001))
    assert all(draw.own for draw in measured.draws)
    fine = measured_with(monkeypatch, learned, tmp_path / "fine", lambda world: ends(0.001), fine=True)
    assert measured.result.joint == fine.result.joint and measured.result.alone == fine.result.alone


def test_what_failed_on_the_coarse_mesh_is_asked_of_the_own_one(
    learned: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = measured_with(
        monkeypatch,
        learned,
        tmp_path,
        lambda world: Verdict(None, None, "tore") if world["hands.offset.up"] > 0.001 else own(world),
    )
    assert all(draw.verdict == own(draw.world) for draw in measured.draws if draw.world["hands.offset.up"] > 0.001)


def test_a_run_on_two_meshes_goes_on_without_simulating_and_says_which_they_were(
    learned: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = measured_with(monkeypatch, learned, tmp_path, own)
    lines = (tmp_path / "simulated.jsonl").read_text()
    again = measured_with(monkeypatch, learned, tmp_path, own)
    assert again.result == first.result and (tmp_path / "simulated.jsonl").read_text() == lines
    assert len(lines.splitlines()) == first.result.simulations
    assert "on the fold's own of 40 mm" in summary(first.result) and "coarser mesh alone" in page(first)


def test_the_sample_goes_from_the_worst_to_the_best() -> None:
    verdicts = [ends(0.001 * (7 * number % 50)) for number in range(50)]
    chosen = [LIMITS.slack(verdicts[number]) for number in select_pairs(verdicts, LIMITS)]
    assert len(chosen) == 6 and min(chosen) == -1.0 and max(chosen) == 1.0
    assert len(select_pairs(4 * verdicts, LIMITS)) == 12
    assert select_pairs(verdicts[:2], LIMITS) == [0, 1]


def test_a_verdict_is_decided_where_the_measured_difference_cannot_change_it() -> None:
    apart = SlackRange(LIMITS).including(
        [MeshVerdict(ends(0.004), ends(0.0065)), MeshVerdict(ends(0.005), ends(0.005))]
    )
    assert (apart.low, apart.high) == pytest.approx((0.0, 0.2))
    assert apart.is_conclusive(ends(0.0124)) and apart.is_conclusive(ends(0.0151))
    assert not apart.is_conclusive(ends(0.0126)) and not apart.is_conclusive(ends(0.0149))
    assert not apart.is_conclusive(Verdict(0.001, 0.79)), "the overlap counts as the distance does"
    assert not SlackRange.unbounded(LIMITS).is_conclusive(ends(0.001))


def test_distances_of_the_coarse_mesh_are_those_that_pairs_make_of_them() -> None:
    pairs = [MeshVerdict(ends(0.8 * d), ends(d + 0.001)) for d in (0.001, 0.002, 0.004, 0.008, 0.016)]
    assert fit_distances(pairs, LIMITS)(0.011) == pytest.approx(0.008)
    far = MeshVerdict(ends(0.3), ends(0.9))
    assert fit_distances([*pairs, far], LIMITS)(0.011) == pytest.approx(0.008, abs=0.002), (
        "how far beyond the limit is one"
    )
    assert fit_distances(pairs[:2], LIMITS)(0.011) == 0.011


def test_slack_is_negative_where_a_fold_does_not_hold() -> None:
    for verdict in (ends(0.0), ends(0.0125), ends(0.0126), ends(0.5), Verdict(0.001, 0.79), Verdict(None, None, "x")):
        assert (LIMITS.slack(verdict) >= 0.0) == LIMITS.hold(verdict) and -1.0 <= LIMITS.slack(verdict) <= 1.0
