"""Margins: found by halving, kept, gone on with, and written as the contract says."""

from __future__ import annotations

import json
import subprocess
import sys
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from tatamu import InputError
from tatamu.after.margins import Measured, measure
from tatamu.after.margins.page import page
from tatamu.after.margins.texts import summary, sureness
from tatamu.api import learn, measure_margins
from tatamu.base.errors import WorkerKilledError
from tatamu.evaluation.disturbances import Disturbances, Scenario, load_disturbances
from tatamu.evaluation.outcome import Outcome
from tatamu.evaluation.success import MarginsRecord, Spread, Success
from tatamu.folding.score import Limits
from tatamu.folding.task import make_task
from tatamu.study.folder import ResultFolder
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result
from tests.commands import tatamu

UP = Disturbances.model_validate({"hands": {"offset": [0.0, 0.0, 0.003], "yaw": 0.01}})
ONE = Disturbances.model_validate({"hands": {"yaw": 0.01}})


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("margins")
    options = LearnOptions(trials=4, disturbances="none", baselines=False)
    learn(make_task("towel", spacing=0.04, size=(0.24, 0.5)), options, out=folder)
    return folder


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Scenario]:
    """Worlds that were simulated, by a simulator in which a fold ends as far away as its hands are off upwards."""
    scenarios: list[Scenario] = []

    def known(task: Any, parameters: Any, scenario: Scenario) -> Outcome:
        scenarios.append(scenario)
        up = scenario["hands.offset.up"]
        return Outcome(None, None, "tore") if up > 0.02 else Outcome(2.0 * abs(up), 0.9)

    monkeypatch.setattr("tatamu.evaluation.draws.simulate_outcome", known)
    return scenarios


def run(folder: Path, out: Path, **options: Any) -> Measured:
    return measure_margins(folder, disturbances=UP, out=out, **{"draws": 30, **options})


def test_margins_are_where_the_fold_fails(learned: Path, asked: list[Scenario], tmp_path: Path) -> None:
    result = run(learned, tmp_path).result
    by_name = {margin.name: margin for margin in result.alone}
    assert set(by_name) == {"hands.offset.up", "hands.yaw"}
    up = by_name["hands.offset.up"]
    assert up.low is not None and up.high is not None
    assert -0.00625 <= up.low <= -0.00625 + 0.0015 and 0.00625 - 0.0015 <= up.high <= 0.00625
    assert (by_name["hands.yaw"].low, by_name["hands.yaw"].high) == (None, None)
    assert by_name["hands.yaw"].tried == pytest.approx((-0.03, 0.03))
    assert sureness(by_name["hands.yaw"]) > sureness(up)


def test_the_share_is_that_of_the_draws(learned: Path, asked: list[Scenario], tmp_path: Path) -> None:
    together = run(learned, tmp_path, draws=200).result.together
    scenarios = asked[-200:] if len(asked) < 200 else [scenario for scenario in asked if len(scenario.values) == 2]
    succeeded = sum(2.0 * abs(scenario["hands.offset.up"]) <= 0.0125 for scenario in scenarios)
    assert together.succeeded == succeeded and together.simulations == 200 and together.rate == succeeded / 200
    assert together.interval[0] < together.rate < together.interval[1]
    assert 0.9 < together.rate < 1.0
    spread = together.mean_vertex_distance
    assert spread.median < spread.q90 < spread.worst


def test_what_failed_in_the_simulator_counts(learned: Path, asked: list[Scenario], tmp_path: Path) -> None:
    wild = Disturbances.model_validate({"hands": {"offset": [0.0, 0.0, 0.02]}})
    measured = measure(Result.load(learned), wild, out=tmp_path, draws=20)
    together = measured.result.together
    assert together.simulations == 20 and together.succeeded < 12
    assert together.mean_vertex_distance.worst > 0.1  # twice what untouched cloth has
    assert measured.draws[0].outcome.error == "tore"


def test_a_scenario_that_kills_its_workers_has_failed_and_ends_nothing(
    learned: Path, asked: list[Scenario], tmp_path: Path
) -> None:
    class Deadly(Executor):
        """Worlds with the hands far up kill the workers that simulate them."""

        def submit(self, function: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
            ended: Future[Any] = Future()
            if args[2]["hands.offset.up"] > 0.003:
                ended.set_exception(WorkerKilledError("killed 3 workers"))
            else:
                ended.set_result(function(*args, **kwargs))
            return ended

    measured = run(learned, tmp_path, executor=Deadly())
    killed = [draw for draw in measured.draws if draw.scenario["hands.offset.up"] > 0.003]
    assert killed and all(draw.outcome == Outcome(None, None, "killed 3 workers") for draw in killed)
    by_name = {margin.name: margin for margin in measured.result.alone}
    high = by_name["hands.offset.up"].high
    assert high is not None and high <= 0.003
    assert measured.result.together.succeeded <= measured.result.together.simulations - len(killed)
    count = len(asked)
    assert run(learned, tmp_path).result == measured.result and len(asked) == count, "a later run goes on"


def test_nothing_is_simulated_twice_and_a_torn_line_costs_one_simulation(
    learned: Path, asked: list[Scenario], tmp_path: Path
) -> None:
    first = run(learned, tmp_path).result
    count = len(asked)
    assert run(learned, tmp_path).result == first and len(asked) == count
    kept = tmp_path / "simulated.jsonl"
    kept.write_bytes(kept.read_bytes()[:-20])
    assert run(learned, tmp_path).result == first and len(asked) == count + 1
    tighter = run(learned, tmp_path, limits=Limits(mean_vertex_distance=0.002)).result
    assert len(asked) < count + 20 and tighter.together.succeeded < first.together.succeeded


def test_margins_do_not_depend_on_how_many_workers_there_are(learned: Path, tmp_path: Path) -> None:
    results = []
    for workers in (1, 3):
        with ThreadPoolExecutor(workers) as pool:
            out = tmp_path / str(workers)
            results.append(measure(Result.load(learned), ONE, out=out, draws=3, executor=pool).result)
    assert results[0] == results[1]


def test_a_killed_run_goes_on(learned: Path, tmp_path: Path) -> None:
    code = (
        "import os, sys; from pathlib import Path\n"
        "from tests.test_margins import ONE; from tatamu.after.margins import measure\n"
        "from tatamu.study.result import Result\n"
        "measure(Result.load(sys.argv[1]), ONE, out=Path(sys.argv[2]), draws=4, "
        "progress=lambda done, total: os._exit(9) if done == 4 else None)"
    )
    ended = subprocess.run([sys.executable, "-c", code, learned, tmp_path / "killed"], check=False)
    assert ended.returncode == 9
    assert len((tmp_path / "killed" / "simulated.jsonl").read_text().splitlines()) == 4
    killed, whole = (measure(Result.load(learned), ONE, out=tmp_path / name, draws=4) for name in ("killed", "whole"))
    assert killed.result == whole.result


def test_the_page_and_the_summary_say_how_sure_the_fold_is(learned: Path, tmp_path: Path) -> None:
    measured = measure(Result.load(learned), ONE, out=tmp_path, draws=5)
    assert measured.result.together.headline in page(measured) and "pair of hands turned" in page(measured)
    assert page(measured) == page(measured)
    assert summary(measured.result).startswith(measured.result.together.headline)


def test_the_file_is_what_the_contract_says(learned: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("[table]\nheight = 0.002\n")
    ended = tatamu("margins", str(learned), "--draws", "3", "--disturbances", str(tmp_path / "mine.toml"))
    assert ended.returncode == 0, ended.stderr
    data = json.loads((learned / "margins" / "margins.json").read_text())
    assert {"limits", "alone", "together", "seed"} <= set(data)
    assert {"simulations", "succeeded", "rate", "interval", "causes", "mean_vertex_distance"} <= set(data["together"])
    assert set(data["together"]["mean_vertex_distance"]) == {"median", "q90", "worst"}
    former = data["joint"]
    assert (former["draws"], former["held"], former["share"]) == tuple(
        data["together"][name] for name in ("simulations", "succeeded", "rate")
    )
    del data["together"], former["simulations"], former["succeeded"], former["rate"]
    assert MarginsRecord.model_validate(data) == ResultFolder(learned).margins, "files of version 0.2 are read"
    assert {"name", "unit", "low", "high"} <= set(data["alone"][0])
    assert ResultFolder(learned).margins is not None


@pytest.mark.parametrize(
    ("options", "said"),
    [({"draws": 0}, "draws"), ({"seed": -1}, "seed"), ({"simulator": "none"}, "simulator")],
)
def test_wrong_options_are_refused(learned: Path, tmp_path: Path, options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        run(learned, tmp_path, **options)


def test_disturbances_without_any_are_refused(learned: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="deviation"):
        measure(Result.load(learned), Disturbances(), out=tmp_path)
    assert load_disturbances("none") is None


def test_the_headline_has_the_rate_with_its_interval() -> None:
    spread = Spread(median=0.003, q90=0.006, worst=0.02)
    found = Success(simulations=200, succeeded=196, rate=0.98, interval=(0.9496, 0.9945), mean_vertex_distance=spread)
    assert found.headline == "succeeds in 196 of 200 simulations (98 %, 95 % interval 95 to 99 %)"
