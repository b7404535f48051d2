"""Datasets in LeRobot's format: what is written is read back by pyarrow and PyAV; nothing is half-written."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.lerobot import LeRobotReader, LeRobotWriter, camera, flag, vector
from tatamu.lerobot.feature import joined, statistics
from tatamu.lerobot.video import VideoWriter
from tests.small_studies import bytes_in

NAMES = ["left_x", "left_y", "left_gripper"]
FEATURES = {"observation.state": vector(NAMES), "next.done": flag(), "observation.images.top": camera(64)}


def _episode(frames: int, seed: int) -> dict[str, np.ndarray]:
    generator = np.random.default_rng(seed)
    pictures = np.zeros((frames, 64, 64, 3), np.uint8)
    for number, picture in enumerate(pictures):
        picture[:, : 4 + 2 * number] = [200, 100, 10 * seed]
    return {
        "observation.state": generator.normal(size=(frames, 3)).astype(np.float32),
        "next.done": np.arange(frames)[:, None] == frames - 1,
        "observation.images.top": pictures,
    }


def _write(root: Path, lengths: list[int], **options: float) -> list[dict[str, np.ndarray]]:
    episodes = [_episode(frames, seed) for seed, frames in enumerate(lengths)]
    with LeRobotWriter(root, 10, FEATURES, "hands", **options) as writer:
        for number, episode in enumerate(episodes):
            writer.add_episode(episode, f"task {number % 2}", {"success": number > 0, "share": None})
    return episodes


def test_a_written_dataset_is_read_back(tmp_path: Path) -> None:
    episodes = _write(tmp_path / "data", [5, 7, 3])
    reader = LeRobotReader(tmp_path / "data")
    assert reader.tasks == ["task 0", "task 1"]
    assert [row["length"] for row in reader.episodes] == [5, 7, 3]
    assert [row["success"] for row in reader.episodes] == [False, True, True]
    for number, episode in enumerate(episodes):
        found = reader.numbers(number, "observation.state", "next.done", "timestamp", "index")
        np.testing.assert_array_equal(found["observation.state"], episode["observation.state"])
        np.testing.assert_array_equal(found["next.done"], episode["next.done"][:, 0])
        np.testing.assert_allclose(found["timestamp"], np.arange(len(episode["next.done"])) / 10)
        assert found["index"][0] == reader.row(number)["dataset_from_index"]
        pictures = list(reader.pictures(number, "observation.images.top"))
        assert len(pictures) == len(episode["next.done"])
        for made, given in zip(pictures, episode["observation.images.top"], strict=True):
            assert np.abs(made.astype(int) - given).mean() < 4.0  # lossy


def test_info_and_statistics_are_those_of_the_format(tmp_path: Path) -> None:
    episodes = _write(tmp_path / "data", [5, 7])
    info = json.loads((tmp_path / "data/meta/info.json").read_text())
    assert (info["codebase_version"], info["total_episodes"], info["total_frames"]) == ("v3.0", 2, 12)
    assert info["splits"] == {"train": "0:2"}
    assert info["features"]["observation.state"] == {"dtype": "float32", "shape": [3], "names": NAMES}
    assert info["features"]["observation.images.top"]["info"]["video.codec"] == "av1"
    stats = json.loads((tmp_path / "data/meta/stats.json").read_text())
    whole = np.concatenate([episode["observation.state"] for episode in episodes]).astype(float)
    np.testing.assert_allclose(stats["observation.state"]["mean"], whole.mean(axis=0))
    np.testing.assert_allclose(stats["observation.state"]["std"], whole.std(axis=0))
    assert np.shape(stats["observation.images.top"]["max"]) == (3, 1, 1)
    assert stats["action" if "action" in stats else "timestamp"]["count"] == [12]


def test_joined_quantiles_weigh_episodes_by_their_length() -> None:
    feature = vector(["x"])
    short, long = np.zeros((1, 1)), np.ones((3, 1))
    found = joined([statistics(feature, short), statistics(feature, long)])
    assert found["q50"] == pytest.approx([0.75])
    assert found["count"].tolist() == [4]


def test_full_files_are_followed_by_the_next(tmp_path: Path) -> None:
    episodes = _write(tmp_path / "data", [60, 4, 4], data_mib=1e-6, video_mib=1e-6)
    reader = LeRobotReader(tmp_path / "data")
    assert [row["data/file_index"] for row in reader.episodes] == [0, 1, 2]
    assert [row["videos/observation.images.top/file_index"] for row in reader.episodes] == [0, 1, 1]
    np.testing.assert_array_equal(
        reader.numbers(2, "observation.state")["observation.state"], episodes[2]["observation.state"]
    )
    assert len(list(reader.pictures(2, "observation.images.top"))) == 4


def test_the_same_episodes_give_the_same_bytes(tmp_path: Path) -> None:
    _write(tmp_path / "one", [5, 6])
    _write(tmp_path / "two", [5, 6])
    written = bytes_in(tmp_path / "one")
    assert len(written) == 6 and written == bytes_in(tmp_path / "two")


@pytest.mark.skipif(not hasattr(os, "sched_getscheduler"), reason="the system has no scheduling policies")
def test_the_encoder_takes_no_processor_from_other_programs(tmp_path: Path) -> None:
    """If root runs the encoder, it makes itself and its caller real-time threads."""
    policy = os.sched_getscheduler(0)
    writer = VideoWriter(tmp_path / "video.mp4", 10, 64, 64)
    writer.add(_episode(3, 0)["observation.images.top"])
    assert {os.sched_getscheduler(int(thread.name)) for thread in Path("/proc/self/task").iterdir()} == {policy}
    writer.close()


def test_an_error_leaves_nothing(tmp_path: Path) -> None:
    writer = LeRobotWriter(tmp_path / "data", 10, FEATURES)
    with pytest.raises(InputError, match=r"observation.state: must have the shape \(4, 3\), given \(4, 2\)"), writer:
        episode = _episode(4, 0)
        writer.add_episode(episode, "one")
        writer.add_episode({**episode, "observation.state": np.zeros((4, 2))}, "one")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"observation.state": np.full((4, 3), np.nan)}, "observation.state: must contain finite numbers"),
        (
            {"observation.images.top": np.zeros((4, 64, 64, 3))},
            "observation.images.top: pictures must be arrays of uint8",
        ),
        ({"extra": np.zeros((4, 1))}, "values: must have the features observation.state"),
    ],
)
def test_wrong_values_are_named(tmp_path: Path, values: dict[str, np.ndarray], message: str) -> None:
    writer = LeRobotWriter(tmp_path / "data", 10, FEATURES)
    with pytest.raises(InputError, match=message):
        writer.add_episode({**_episode(4, 0), **values}, "one")


def test_a_folder_with_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="must be a new folder"):
        LeRobotWriter(tmp_path / "data", 10, FEATURES)
    with pytest.raises(InputError, match=r"has no meta/info\.json"):
        LeRobotReader(tmp_path / "data")


def test_another_version_is_refused(tmp_path: Path) -> None:
    _write(tmp_path / "data", [3])
    file = tmp_path / "data/meta/info.json"
    file.write_text(file.read_text().replace('"v3.0"', '"v2.1"'))
    with pytest.raises(InputError, match=r"codebase_version: must be v3.0, given 'v2.1'"):
        LeRobotReader(tmp_path / "data")


def test_a_foreign_dataset_names_no_file_outside(tmp_path: Path) -> None:
    episodes = _write(tmp_path / "data", [3])
    file = tmp_path / "data/meta/info.json"
    info = json.loads(file.read_text())
    info["data_path"], info["video_path"] = "../{chunk_index:999999d}.parquet", "/etc/{video_key}{file_index}"
    file.write_text(json.dumps(info))
    reader = LeRobotReader(tmp_path / "data")
    state = reader.numbers(0, "observation.state")["observation.state"]
    np.testing.assert_array_equal(state, episodes[0]["observation.state"])
    assert len(list(reader.pictures(0, "observation.images.top"))) == 3


def test_a_missing_encoder_is_reported_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tatamu.lerobot.video.CODEC", "libnothing")
    with pytest.raises(InputError, match="videos need the encoder libnothing"):
        LeRobotWriter(tmp_path / "data", 10, FEATURES)
    assert not list(tmp_path.iterdir())
