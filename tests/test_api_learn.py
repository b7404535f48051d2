"""`tatamu.learn`: the same as the command, in memory or in a folder, and with parts of the user's own."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tatamu
from tatamu import (
    Ask,
    Evaluation,
    Garment,
    InputError,
    LearnOptions,
    Manipulation,
    Nominal,
    Result,
    Rollout,
    Scene,
    Search,
    Task,
    Wrapper,
    make_task,
    register_garment,
    register_search,
    register_simulator,
)
from tatamu.cli import main
from tatamu.evaluation.disturbances import NOMINAL, default_disturbances
from tatamu.evaluation.nominal import unsimulated
from tatamu.folding.manipulation import Course
from tatamu.garments import towel as make_towel
from tatamu.search import Parameters
from tatamu.simulation import native
from tests import shifted
from tests.refusals import refusal
from tests.small_studies import (
    X,
    learn_plain,
    over_scenarios,
    plain,
    timeless,
    towel,
    without_times,
)

TINY: dict[str, Any] = {"size": (0.16, 0.30), "spacing": 0.03}


@pytest.fixture(scope="module", autouse=True)
def _quick() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tatamu.study.loop.SUCCESS_SIMULATIONS", 6)
        yield


def tiny(**changes: Any) -> Task:
    return towel(**{**TINY, **changes})


def same_arrays(one: Rollout, other: Rollout) -> bool:
    """Whether two rollouts are the same to the last bit."""
    pairs = [(one.times, other.times), (one.positions, other.positions), (one.faces, other.faces)]
    pairs += [(one.extra[name], other.extra[name]) for name in one.extra]
    return one.extra.keys() == other.extra.keys() and all(a.tobytes() == b.tobytes() for a, b in pairs)


def test_a_script_and_the_command_write_the_same_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    task = make_task("towel", **TINY)
    with pytest.warns(UserWarning, match="the cloth may drape too stiffly"):
        tatamu.learn(task, LearnOptions(trials=3, seed=1), out=tmp_path / "script")
    words = ["learn", "towel", "--size", "0.16x0.30", "--spacing", "0.03", "--trials", "3", "--seed", "1"]
    monkeypatch.setattr("sys.argv", ["tatamu", *words, "--out", str(tmp_path / "command")])
    with pytest.raises(SystemExit) as ended:
        main()
    assert not ended.value.code
    script, command = (tmp_path / name for name in ("script", "command"))
    assert {path.name for path in script.iterdir()} == {path.name for path in command.iterdir()}
    assert timeless(script) == timeless(command)
    for name in ("manipulation.json", "scene.json"):
        assert (script / name).read_bytes() == (command / name).read_bytes()
    one, other = (Rollout.load(folder / "rollout.npz") for folder in (script, command))
    assert same_arrays(one, other)
    assert without_times(one.info) == without_times(other.info)


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return learn_plain(tiny(), tmp_path_factory.mktemp("kept"), trials=4)


@pytest.fixture(scope="module")
def in_memory() -> Result:
    return learn_plain(tiny(), None, trials=4)


def test_a_result_in_memory_is_the_one_in_a_folder(kept: Result, in_memory: Result) -> None:
    assert in_memory.folder is None
    assert without_times(in_memory.record.model_dump()) == without_times(kept.record.model_dump())
    assert in_memory.manipulation.describe().model_dump() == kept.manipulation.describe().model_dump()
    assert in_memory.scene.model_dump_json() == kept.scene.model_dump_json()
    assert same_arrays(in_memory.rollout, kept.rollout)
    assert in_memory.score == kept.score


def test_what_is_saved_is_what_is_loaded(in_memory: Result, tmp_path: Path) -> None:
    in_memory.save(tmp_path)
    loaded = tatamu.load(tmp_path)
    assert isinstance(loaded, Result)
    assert loaded.record.model_dump() == in_memory.record.model_dump()
    assert loaded.best == in_memory.best
    assert loaded.scene.model_dump_json() == in_memory.scene.model_dump_json()
    assert same_arrays(loaded.rollout, in_memory.rollout)
    assert loaded.score == in_memory.score
    assert same_manipulation(loaded.manipulation, in_memory.manipulation)
    assert loaded.task.fold.target.tobytes() == in_memory.target.tobytes()


def test_the_table_has_a_row_for_each_trial(in_memory: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    table = in_memory.table()
    assert {len(column) for column in table.values()} == {4}
    assert table["number"] == [0, 1, 2, 3] and table["state"] == ["complete"] * 4
    assert {"x1", "z1", "x2", "z2", "g1", "g2", "minimised", "mask_iou", "seconds"} <= table.keys()
    assert table["minimised"][in_memory.best.number] == in_memory.best.objective == min(table["minimised"])  # type: ignore[type-var]
    count = iter(range(100))
    simulate = native.simulate

    def sometimes(scene: Scene) -> Rollout:
        if next(count) == 1:
            raise tatamu.SimulationError("blew up")
        return simulate(scene)

    monkeypatch.setattr(native, "simulate", sometimes)
    failed = learn_plain(tiny(), None, trials=3, baselines=False, parallel=1).table()
    assert failed["state"] == ["complete", "failed", "complete"]
    assert {len(column) for column in failed.values()} == {3}
    assert failed["mask_iou"][1] is None and failed["minimised"][1] is not None


def test_a_result_in_memory_writes_its_page_where_it_is_told(in_memory: Result, tmp_path: Path) -> None:
    page = in_memory.write_report(tmp_path / "page.html")
    assert page == tmp_path / "page.html" and "</html>" in page.read_text()
    with pytest.raises(InputError):
        in_memory.write_report()


class Gentle(Wrapper):
    """A high first control point costs something."""

    def __call__(self, ask: Ask | Mapping[str, int | float]) -> Evaluation:
        found = self.inner(ask)
        return replace(found, objective=found.objective + 0.1 * found.parameters["z1"])


def test_an_evaluator_of_ones_own_is_minimised(tmp_path: Path) -> None:
    task = tiny()
    result = tatamu.learn(task, LearnOptions(trials=4), evaluate=Gentle(Nominal(task)), out=tmp_path)
    assert isinstance(result, Result)
    for trial in result.trials:
        assert trial.score is not None
        assert trial.minimised == trial.score.objective + 0.1 * trial.parameters["z1"]
        assert trial.objective == trial.score.objective, "C stays C"
    assert result.best.minimised == min(trial.minimised for trial in result.trials)
    assert result.record.disturbances is None and result.success is None
    loaded = tatamu.load(tmp_path)
    assert isinstance(loaded, Result) and loaded.record.model_dump() == result.record.model_dump()
    resumed = tatamu.learn(task, LearnOptions(trials=6), evaluate=Gentle(Nominal(task)), out=tmp_path)
    at_once = tatamu.learn(task, LearnOptions(trials=6), evaluate=Gentle(Nominal(task)))
    assert isinstance(resumed, Result) and isinstance(at_once, Result)
    assert without_times(resumed.record.model_dump()) == without_times(at_once.record.model_dump())


def test_the_fingers_of_disturbances_that_are_not_used_do_not_change_the_task() -> None:
    task = tiny()
    result = tatamu.learn(task, LearnOptions(trials=1, baselines=False), evaluate=Nominal(task))
    assert isinstance(result, Result)
    assert result.task.fingers == task.fingers and result.record.task.fingers is None


def far_from_middle(parameters: Mapping[str, int | float]) -> float:
    return 1.0 + abs(parameters["x1"] - 0.05)


def test_an_objective_of_ones_own_is_minimised(tmp_path: Path) -> None:
    result = tatamu.learn(tiny(), LearnOptions(trials=5, parallel=1), evaluate=far_from_middle, out=tmp_path)
    assert isinstance(result, Result)
    assert [trial.minimised for trial in result.trials] == [far_from_middle(t.parameters) for t in result.trials]
    assert result.best.minimised == min(trial.minimised for trial in result.trials)
    assert result.score == result.best.score
    loaded = tatamu.load(tmp_path)
    assert isinstance(loaded, Result) and loaded.record.model_dump() == result.record.model_dump()


class Halving(Search):
    """Draws from the whole space, then halves the way to the best."""

    def propose(self) -> tuple[Parameters, float | None]:
        drawn = self.space.random(self.sub_seed())
        if not self.known:
            return drawn, None
        best = min(self.known, key=lambda each: each.objective).parameters
        return {n: each.nearest(0.5 * (best[n] + drawn[n])) for n, each in self.space.bounds.items()}, None


def test_a_search_of_ones_own_learns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.search.search._REGISTERED", {})
    register_search("halving", Halving)
    for trials in (3, 7):
        result = learn_plain(tiny(), tmp_path, sampler="halving", trials=trials, baselines=False)
    at_once = learn_plain(tiny(), None, sampler="halving", trials=7, baselines=False)
    assert without_times(result.record.model_dump()) == without_times(at_once.record.model_dump())
    assert result.record.sampler == "halving" and len(result.trials) == 7
    with pytest.raises(InputError, match="name: must be new"):
        register_search("halving", Halving)
    with pytest.raises(InputError, match=r"sampler: must be one of gp, .*, halving, given 'none'"):
        LearnOptions(sampler="none")


class Beyond(Search):
    """Proposes what lies outside its space."""

    def propose(self) -> tuple[Parameters, float | None]:
        return {**self.space.middle(), "x1": 10.0}, None


def test_a_search_that_leaves_its_space_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.search.search._REGISTERED", {"beyond": Beyond})
    with pytest.raises(InputError, match=r"sampler: beyond proposed .*x1: must be a number from 0 to .*given 10"):
        learn_plain(tiny(), None, sampler="beyond", trials=2)


def napkin(size: tuple[float, float] = (0.24, 0.3), **given: Any) -> Garment:
    return replace(make_towel(size=size, **{"spacing": 0.04, **given}), name="napkin")


def test_a_garment_of_ones_own_is_learned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("GARMENTS", "DESCRIPTIONS"):
        monkeypatch.setattr(f"tatamu.garments.{name}", dict(getattr(tatamu.garments, name)))
    register_garment("napkin", napkin, "a square")
    result = learn_plain(make_task("napkin"), tmp_path, trials=2, baselines=False)
    assert result.record.task.garment == "napkin" and result.record.task.size == [0.24, 0.3]
    loaded = tatamu.load(tmp_path)
    assert isinstance(loaded, Result) and loaded.task.garment.name == "napkin"
    with pytest.raises(InputError, match="name: must be new"):
        register_garment("napkin", napkin)


def test_a_simulator_of_ones_own_learns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.simulation.simulators.SIMULATORS", dict(tatamu.simulation.simulators.SIMULATORS))
    monkeypatch.setattr(shifted, "SHIFT", np.array([0.0, 0.0, 0.001]))
    register_simulator("shifted", shifted)
    calls = len(shifted.CALLS)
    result = learn_plain(tiny(simulator="shifted"), tmp_path, trials=2, baselines=False)
    assert len(shifted.CALLS) - calls == 2
    assert result.rollout.info["simulator"] == result.simulator == "shifted"
    assert np.array_equal(result.final, native.simulate(result.scene).positions[-1] + shifted.SHIFT)
    with pytest.raises(InputError, match="name: must be new"):
        register_simulator("shifted", shifted)


def same_manipulation(one: Manipulation, other: Manipulation) -> bool:
    """Whether two manipulations are the same to the last bit."""

    def plain_values(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return value.shape, value.astype(float).tobytes()
        if isinstance(value, Manipulation | Course):
            value = tuple(getattr(value, each.name) for each in fields(value))
        return tuple(map(plain_values, value)) if isinstance(value, tuple) else value

    return bool(plain_values(one) == plain_values(other))


@pytest.mark.parametrize(
    "made", [{}, {"hands": 1}, {"garment": "tshirt", "spacing": 0.04}, {"garment": "trousers", "fold": "leg"}]
)
def test_a_manipulation_survives_its_file_to_the_last_bit(made: dict[str, Any], tmp_path: Path) -> None:
    task = make_task(**{"garment": "towel", "spacing": 0.04, **made})
    later = task if task.step[1] == 1 else task.next(task.fold.target)
    for number, each in enumerate((task, later)):
        manipulation = each.manipulation(each.space.random(number))
        manipulation.save(tmp_path / "manipulation.json")
        loaded = Manipulation.load(tmp_path / "manipulation.json")
        assert same_manipulation(loaded, manipulation)
        times, moved = manipulation.motion()
        again, moved_again = loaded.motion()
        assert times.tobytes() == again.tobytes()
        assert [path.tobytes() for path in moved] == [path.tobytes() for path in moved_again]
        assert loaded.timing == manipulation.timing
        assert loaded.trajectory_length == manipulation.trajectory_length


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"g1": 99}, "^g1: must be the index of a grasp, 0 to .*given 99"),
        ({"g2": -1}, "^g2: must be the index of a grasp"),
        ({"z1": -0.01}, "^z1: must be a height of at least 0 m"),
        ({"x1": float("nan")}, "^x1: must be a finite number, given nan"),
        ({"x2": float("inf")}, "^x2: must be a finite number"),
        ({"z2": "high"}, "^z2: must be a finite number, given 'high'"),
        ({"g1": None}, "^g1: must be a finite number"),
    ],
)
def test_wrong_parameters_are_refused_by_name(change: dict[str, Any], named: str) -> None:
    wrong = {**X, **change}
    wrong = {name: value for name, value in wrong.items() if value is not None}
    task = towel()
    nominal = Nominal(task)
    calls: list[Any] = [task.manipulation, nominal, over_scenarios(task)]
    calls += [lambda given: nominal.simulate(given, NOMINAL), lambda given: unsimulated(task, given, "why")]
    for call in calls:
        with pytest.raises(InputError, match=named):
            call(wrong)


def test_options_of_version_0_2_warn_and_have_no_effect() -> None:
    for name, value in (("quantile", 0.9), ("coarse", False)):
        with pytest.warns(FutureWarning, match=f"^{name}: no longer has an effect"):
            assert LearnOptions(**{name: value}) == LearnOptions()
    with pytest.warns(FutureWarning, match="use Scenarios"):
        assert isinstance(tatamu.Disturbed(Nominal(towel()), default_disturbances(), 0.9), tatamu.Scenarios)
    with pytest.warns(FutureWarning, match="one mesh"):
        assert isinstance(tatamu.CoarseFirst(Nominal(towel())), Nominal)


def test_wrong_options_are_refused_by_name_before_anything_is_made(tmp_path: Path) -> None:
    for change, named in (
        ({"trials": 0}, "^trials"),
        ({"trials": 2.5}, "^trials"),
        ({"seed": -1}, "^seed"),
        ({"sampler": "magic"}, "^sampler"),
        ({"parallel": 17}, "^parallel"),
        ({"level": 0.0}, "^level"),
        ({"level": float("nan")}, "^level"),
        ({"aim": "0.1x0.2"}, "^aim"),
        ({"aim": "0.1x0.1x0.1"}, "^aim"),
        ({"grasps": "some"}, "^grasps"),
        ({"trails": 5}, "^trails"),
    ):
        assert re.search(named, refusal(LearnOptions, **change))
    for wrong in (17, "nowhere.toml"):
        with pytest.raises(InputError, match=r"^disturbances: must be .*given 17|nowhere\.toml: cannot be read"):
            tatamu.learn(tiny(), LearnOptions(trials=1, disturbances=wrong), out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_progress_counts_up_to_the_end() -> None:
    seen: list[tatamu.Progress] = []
    tatamu.learn(tiny(), plain(trials=3, baselines=False), progress=seen.append)
    assert [each.done for each in seen if each.stage == "trials"] == [0, 1, 2, 3]
    assert all(each.trials == 3 for each in seen)
    best = [each.best for each in seen if each.best is not None]
    assert best == sorted(best, reverse=True), "on one mesh the best never gets worse"
