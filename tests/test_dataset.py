"""Datasets of folds: the same bytes however they are made, what every fold is worth, and actions that fold again."""

from __future__ import annotations

import json
import re
import shutil
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.base.errors import InputError, UnavailableError
from tatamu.folding.score import MEASURES
from tatamu.lerobot import LeRobotReader
from tatamu.policies.dataset import DatasetFolder, DatasetSpecification, make_dataset, read_specification, replay
from tatamu.policies.dataset.distribution import Normal, Uniform, draw, highest
from tatamu.policies.dataset.record import EpisodeRecord, read_records, with_shares
from tatamu.policies.dataset.sources import draw_fold, read_runs
from tatamu.policies.dataset.states import read_states
from tatamu.study.result import Result
from tests.refusals import refusal
from tests.small_studies import bytes_in
from tests.test_full_disk import files_of

SMALL: dict[str, Any] = {
    "episodes": 4,
    "per_fold": 2,
    "seed": 3,
    "garment": {"width": {"low": 0.18, "high": 0.24}, "length": {"low": 0.28, "high": 0.36}, "spacing": 0.04},
    "fold": {"spread": 0.02},
    "record": {"cameras": ["top"], "pixels": 64},
}


def specification(**changes: Any) -> DatasetSpecification:
    return DatasetSpecification.model_validate({**SMALL, **changes})


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> DatasetFolder:
    return make_dataset(specification(), tmp_path_factory.mktemp("dataset") / "folds")


def test_every_episode_says_what_its_fold_is_worth(made: DatasetFolder) -> None:
    rows = LeRobotReader(made.path).episodes
    assert len(rows) == 4 and [row["fold"] for row in rows] == [0, 0, 1, 1]
    for row in rows:
        assert isinstance(row["success"], bool)
        assert all(isinstance(row[name], float) for name in MEASURES)
        assert row["held_from"] == "episodes" and row["held_draws"] == 2
        siblings = [each["success"] for each in rows if each["fold"] == row["fold"]]
        assert row["held_share"] == np.mean(siblings)
        low, high = row["held_interval"]
        assert low <= row["held_share"] <= high and high - low > 0.5
        assert json.loads(row["world"])["hands.offset.along"]
    assert len({row["world"] for row in rows}) == 4
    assert rows[0]["size"] == rows[1]["size"] != rows[2]["size"]
    assert 0.18 <= rows[0]["size"][0] <= 0.24 < 0.28 <= rows[0]["size"][1] <= 0.36


def test_both_formats_have_the_same(made: DatasetFolder) -> None:
    reader = LeRobotReader(made.path)
    assert reader.tasks == ["Fold the towel: in half across the length."]
    for number, record in enumerate(read_records(made.table)):
        states = read_states(made.states, number, ["positions", "hands", "mask", "action", "key_points", "faces"])
        found = reader.numbers(number, "observation.state", "action", "observation.environment_state", "next.success")
        assert len(found["action"]) == record.frames == len(states["positions"]) - 1
        np.testing.assert_array_equal(found["action"], states["action"])
        np.testing.assert_array_equal(found["observation.state"], states["hands"][:-1])
        flat = states["key_points"][:-1].reshape(record.frames, -1)
        np.testing.assert_array_equal(found["observation.environment_state"], flat)
        assert found["next.success"].tolist() == [False] * (record.frames - 1) + [record.success]
        assert states["positions"].shape[1] == record.vertices == states["faces"].max() + 1
        seen = [picture.astype(int) for picture in reader.pictures(number, "observation.images.top")]
        blue = seen[0][..., 2] > seen[0][..., 0] + 20
        assert blue[states["mask"][0] == 1].mean() > 0.9  # the outside of the cloth is blue


def test_the_page_shows_every_outcome(made: DatasetFolder) -> None:
    page = made.page.read_text()
    assert page.count("<figure><img") == 4
    about = made.read()
    assert f"{about.successes} of 4 succeed" in page and about.successes >= 1


def test_actions_end_where_they_were_recorded_to_end(made: DatasetFolder) -> None:
    for episode in (0, 3):
        found = replay(made.path, episode)
        assert not found.differs and found.distances.max() == 0.0
        assert found.recorded.score is not None
        assert found.score.mean_vertex_distance == found.recorded.score.mean_vertex_distance


def test_changed_actions_end_elsewhere(made: DatasetFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    actions = LeRobotReader(made.path).numbers(0, "action")["action"]
    actions[5:10, 2] = 1.0
    monkeypatch.setattr("tatamu.policies.dataset.rerun._actions", lambda *_: actions)
    assert replay(made.path, 0).differs


def test_the_same_bytes_one_at_a_time(made: DatasetFolder, tmp_path: Path) -> None:
    with ThreadPoolExecutor(1) as one:
        again = make_dataset(specification(), tmp_path / "folds", executor=one)
    assert bytes_in(made.path) == bytes_in(again.path)
    assert make_dataset(specification(), again.path).is_finished
    assert bytes_in(made.path) == bytes_in(again.path)


class Dying(Executor):
    """Workers that die after some episodes."""

    def __init__(self, episodes: int) -> None:
        self.left = episodes

    def submit(self, function: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        answer: Future[Any] = Future()
        self.left -= 1
        if self.left < 0:
            answer.set_exception(KeyboardInterrupt())
        else:
            answer.set_result(function(*args, **kwargs))
        return answer


def test_an_interrupted_dataset_is_resumed(
    made: DatasetFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = DatasetFolder(tmp_path / "folds")
    monkeypatch.setattr(
        "tatamu.policies.dataset.make.UNDER_WAY", 1
    )  # otherwise the worker that dies may be the first to end
    with pytest.raises(KeyboardInterrupt):
        make_dataset(specification(), out.path, executor=Dying(3))
    assert not out.is_finished and len(list(out.path.glob(".episodes/*.npz"))) == 3
    with pytest.raises(InputError, match="is unfinished; run the same `tatamu dataset` command again"):
        out.read()
    with pytest.raises(InputError, match="was made from another dataset file; give another --out"):
        make_dataset(specification(seed=4), out.path)
    again = Dying(3)
    make_dataset(specification(), out.path, executor=again)
    assert bytes_in(made.path) == bytes_in(out.path)


@pytest.mark.parametrize("built", [(), ("data",), ("data", "videos", "meta", "states.zarr")])
def test_a_dataset_that_was_half_put_in_its_place_is_finished(
    made: DatasetFolder, tmp_path: Path, built: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = DatasetFolder(tmp_path / "folds")
    monkeypatch.setattr("tatamu.policies.dataset.folder.FINISHED", built)
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr("tatamu.policies.dataset.folder.shutil.rmtree", _interrupt)
        make_dataset(specification(episodes=1), out.path)
    monkeypatch.undo()
    make_dataset(specification(episodes=1), out.path)
    assert out.is_finished and not out.building.exists() and not out.started_file.exists()
    assert LeRobotReader(out.path).numbers(0, "action")["action"].shape[1] == 8


def _interrupt(path: Path, *_: Any, **__: Any) -> None:
    if Path(path).name == ".building" and Path(path).exists():
        raise KeyboardInterrupt


@pytest.mark.usefixtures("made")  # compiled kernels have larger files
def test_a_full_disk_is_one_line_and_the_run_is_resumed(tmp_path: Path) -> None:
    small = specification(episodes=1)
    for most in (10_000, 60_000):
        with files_of(most), pytest.raises(UnavailableError, match="cannot be written") as stopped:
            make_dataset(small, tmp_path / "folds")
        assert "\n" not in str(stopped.value)
        assert not DatasetFolder(tmp_path / "folds").is_finished
    assert make_dataset(small, tmp_path / "folds").read().episodes == 1


def test_another_version_and_other_folders_are_refused(made: DatasetFolder, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="must be the folder of a dataset, but is not a folder"):
        replay(tmp_path / "nothing", 0)
    with pytest.raises(InputError, match=r"has no dataset\.json"):
        replay(tmp_path, 0)
    with pytest.raises(InputError, match=r"^episode: must be from 0 to 3, given 9"):
        replay(made.path, 9)
    shutil.copytree(made.path, tmp_path / "copy")
    file = DatasetFolder(tmp_path / "copy").file
    file.write_text(file.read_text().replace('"version": 1', '"version": 2', 1))
    with pytest.raises(InputError, match=r"dataset\.json: version: must be 1, given 2"):
        replay(tmp_path / "copy", 0)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    with pytest.raises(InputError, match="must be a new folder or the folder of a dataset"):
        make_dataset(specification(), tmp_path / "mine")
    assert (tmp_path / "mine/notes.txt").read_text() == "mine"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("episodes = 0", r"episodes"),
        ("episodes = 2\nepisode = 3", r"episode"),
        ("episodes = 2\nversion = 2", r"version"),
        ('episodes = 2\nformats = ["zarr", "zarr"]', r"formats must not contain the same name twice"),
        ("episodes = 2\nformats = []", r"formats"),
        ('episodes = 2\n[garment]\nwidth = "wide"\nlength = 0.4', r"garment.width.*must be a number, a list"),
        (f"episodes = 2\n[garment]\nwidth = {10**400}\nlength = 0.4", r"garment.width.*must be a number, a list"),
        ("episodes = 2\n[garment]\nwidth = 0.3", r"garment.*length must be given if width is given"),
        ("episodes = 2\n[garment]\nwidth = { low = 0.4, high = 0.3 }\nlength = 0.4", r"low must not be above high"),
        ("episodes = 2\n[garment]\nname = []", r"garment.name.*must be a name, or a list of names"),
        ('episodes = 2\n[fold]\nsource = "learned"', r"fold.*runs must be given"),
        (
            'episodes = 2\n[fold]\nruns = ["a"]',
            r"fold.*runs must be left out if source is 'drawn'; give source = 'learned'",
        ),
        (
            'episodes = 2\n[garment]\n[fold]\nsource = "sweep"\nsweep = "a"',
            r"garment must be left out for learned folds",
        ),
        ('episodes = 2\n[record]\ncameras = ["top", "top"]', r"cameras must not contain the same name twice"),
        ('episodes = 2\n[record]\ncameras = ["above"]', r"record.cameras"),
        ("episodes = 2\n[record]\nfps = 1000", r"record.fps"),
        (
            'episodes = 2\ndisturbances = "none"\n[outcome]\nworlds = 3',
            r"outcome.worlds must be 0 if disturbances is 'none'",
        ),
        ('episodes = 2\n[outcome]\nsimulator = "newton"', r"outcome.simulator"),
    ],
)
def test_a_wrong_field_is_one_line_with_its_name(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "spec.toml"
    file.write_text(text)
    said = refusal(read_specification, file)
    assert re.search(message, said) and str(file) in said


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"garment": {"name": "sock"}}, "garment"),
        ({"garment": {"material": "steel"}}, "material"),
        ({"fold": {"plan": "twice"}}, "fold"),
        ({"disturbances": "loud"}, "disturbances"),
        ({"garment": None, "fold": {"source": "learned", "runs": ["nowhere"]}}, "nowhere"),
        ({"garment": None, "fold": {"source": "sweep", "sweep": "nowhere"}}, "nowhere"),
        ({"robot": {"name": "r2d2"}}, "robot"),
    ],
)
def test_a_wrong_name_is_refused_before_anything_is_recorded(
    tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        make_dataset(specification(**changes), tmp_path / "folds")
    assert not list(tmp_path.rglob("*.npz"))


def test_draws_depend_on_the_seed_and_the_number_alone() -> None:
    one, other = specification(), specification(seed=4)
    assert draw_fold(one, [], 5) == draw_fold(one, [], 5) != draw_fold(one, [], 6)
    assert draw_fold(one, [], 5) != draw_fold(other, [], 5)
    assert draw_fold(one, [], 5, attempt=1) != draw_fold(one, [], 5)


def test_distributions_draw_what_they_say() -> None:
    generator = np.random.default_rng(0)
    numbers = np.array([draw(Uniform(low=1.0, high=2.0), generator) for _ in range(500)])
    assert 1.0 <= numbers.min() < 1.02 and 1.98 < numbers.max() <= 2.0
    numbers = np.array([draw(Normal(mean=1.0, deviation=0.1), generator) for _ in range(500)])
    assert (
        abs(numbers.mean() - 1.0) < 0.02
        and 0.75 < numbers.min()
        and numbers.max() <= highest(Normal(mean=1.0, deviation=0.1))
    )
    assert {draw([1.0, 2.0], generator) for _ in range(20)} == {1.0, 2.0} and draw(3.0, generator) == 3.0


def test_a_learned_fold_is_shown_with_its_neighbours(folder: Path) -> None:
    given = {"garment": None, "fold": {"source": "learned", "runs": [str(folder)], "spread": 0.0}}
    learned = specification(**given)
    runs = read_runs(learned)
    assert len(runs) == 1 and runs[0].source == str(folder)
    drawn = draw_fold(learned, runs, 7)
    assert drawn.middle == Result.load(folder).best.parameters and drawn.subject == runs[0].subject
    assert drawn.subject.garment == "towel" and isinstance(drawn.subject.material, dict)


def test_nothing_runs_that_a_foreign_dataset_names_as_a_codec(made: DatasetFolder, tmp_path: Path) -> None:
    """Codecs of Zarr 2 include pickle, which older versions of numcodecs run."""
    numcodecs: Any = pytest.importorskip("numcodecs")
    import zarr

    shutil.copytree(made.path, tmp_path / "foreign")
    folder = DatasetFolder(tmp_path / "foreign")
    shutil.rmtree(folder.states)
    ran: list[str] = []

    class Planted(numcodecs.abc.Codec):
        codec_id = "planted"

        def encode(self, buf: Any) -> Any:
            return buf

        def decode(self, buf: Any, out: Any = None) -> Any:
            ran.append("decoded")
            return buf

    numcodecs.register_codec(Planted)
    group = zarr.open_group(store=str(folder.states), mode="w", zarr_format=2)
    for name in ("length", "action"):
        array = group.create_array(name, shape=(4,), dtype="i8", compressors=Planted())
        array[:] = np.arange(4)
    with pytest.raises(InputError, match=r"states\.zarr: "):
        read_states(folder.states, 0, ["action"])
    assert not ran


@pytest.mark.parametrize(("shape", "chunks"), [([2, 10**9, 9], [1, 10**8, 9]), ([2, 10**6, 8], [1, 16, 8])])
def test_states_that_would_take_minutes_are_refused(tmp_path: Path, shape: list[int], chunks: list[int]) -> None:
    import zarr

    group = zarr.create_group(store=str(tmp_path / "s.zarr"))
    group.create_array("length", data=np.array([3, 3]))
    group.create_array("action", shape=tuple(shape), chunks=tuple(chunks), dtype="f4")
    assert "action: an episode must have at most" in refusal(read_states, tmp_path / "s.zarr", 0, ["action"])


def test_consolidated_metadata_of_zarr_2_is_not_believed(made: DatasetFolder, tmp_path: Path) -> None:
    root = tmp_path / "states.zarr"
    shutil.copytree(made.states, root)
    about = json.loads((root / "zarr.json").read_text())
    planted = {"zarr_format": 2, "shape": [4], "chunks": [4], "dtype": "<i8", "compressor": {"id": "pickle"}}
    planted |= {"fill_value": 0, "order": "C", "filters": None, "dimension_separator": ".", "attributes": {}}
    about["consolidated_metadata"] = {"kind": "inline", "must_understand": False, "metadata": {"length": planted}}
    (root / "zarr.json").write_text(json.dumps(about))
    assert read_states(root, 0, ["action"])["action"].shape[1] == 8


def _record(episode: int, fold: int, success: bool, **more: Any) -> EpisodeRecord:
    plain: dict[str, Any] = {"task": "", "source": "drawn", "garment": "towel", "plan": "half", "material": {}}
    plain |= {"parameters": {}, "world": {}, "frames": 1, "vertices": 1, "score": None}
    return EpisodeRecord(episode=episode, fold=fold, success=success, **plain, **more)


def test_the_share_of_a_fold_is_of_its_scenarios_or_of_its_episodes() -> None:
    records = [_record(0, 0, True), _record(1, 0, False), _record(2, 1, True).with_share(9, 10, "worlds")]
    records += [_record(3, 1, False), _record(4, 2, True)]
    shared = with_shares(records, disturbed=True)
    assert [each.held_share for each in shared] == [0.5, 0.5, 0.9, 0.9, None]
    assert [each.held_from for each in shared] == ["episodes", "episodes", "worlds", "worlds", ""]
    assert shared[0].held_interval == pytest.approx((0.0126, 0.9874), abs=1e-3)  # Clopper and Pearson, 1 of 2
    assert [each.held_share for each in with_shares(records[:2], disturbed=False)] == [None, None]
