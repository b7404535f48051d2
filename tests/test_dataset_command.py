"""`tatamu dataset` and `tatamu replay` as a user runs them: the example, bad input, and kill -9."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tatamu.policies.dataset import DatasetFolder, make_dataset, read_specification, replay
from tests.commands import Ended, tatamu
from tests.small_studies import bytes_in
from tests.test_full_disk import files_of

EXAMPLE = Path(__file__).parent.parent / "examples" / "dataset.toml"
SMALL = """
episodes = {episodes}
[garment]
width = 0.2
length = {{ low = 0.28, high = 0.32 }}
spacing = 0.04
[record]
cameras = ["top"]
pixels = 64
"""


def written(folder: Path, episodes: int) -> Path:
    """Write a specification of small towels."""
    file = folder / "spec.toml"
    file.write_text(SMALL.format(episodes=episodes))
    return file


def ended_with(ended: Ended, words: str) -> None:
    """Check that a command ended with exit code 2 and, after its progress, one line that contains the words."""
    assert ended.returncode == 2 and not ended.stdout and "Traceback" not in ended.stderr
    line = ended.stderr.splitlines()[-1]
    assert line.startswith("tatamu: ") and words in line, line


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of one episode."""
    folder = tmp_path_factory.mktemp("command")
    ended = tatamu("dataset", str(written(folder, 1)), "--workers", "1", "--out", str(folder / "folds"))
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.splitlines()[-2:] == [
        f"{DatasetFolder(folder / 'folds').read().successes} of 1 episodes succeed; the dataset has "
        f"{DatasetFolder(folder / 'folds').read().frames} frames",
        f"dataset: {folder / 'folds/dataset.html'}",
    ]
    return folder / "folds"


def test_the_example_is_recorded(tmp_path: Path) -> None:
    example = read_specification(EXAMPLE)
    assert example.episodes == 24
    made = make_dataset(example.model_copy(update={"episodes": 1}), tmp_path / "folds")
    assert made.read().successes == 1


def test_an_episode_is_replayed_without_a_difference(made: Path) -> None:
    ended = tatamu("replay", str(made), "0")
    assert ended.returncode == 0
    assert ended.stdout.splitlines()[-1] == "vertices differ from the recording by 0 mm on average and by at most 0 mm"


def test_a_wrong_field_is_one_line(tmp_path: Path) -> None:
    file = written(tmp_path, 1)
    file.write_text(file.read_text().replace("pixels = 64", "pixels = 63"))
    ended = tatamu("dataset", str(file), "--out", str(tmp_path / "folds"))
    ended_with(ended, f"{file}: record.pixels: Input should be a multiple of 2, given 63")
    assert not (tmp_path / "folds").exists()


def test_a_missing_codec_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.lerobot.video.CODEC", "libnothing")
    ended = tatamu("dataset", str(written(tmp_path, 1)), "--workers", "1", "--out", str(tmp_path / "folds"))
    ended_with(ended, "videos need the encoder libnothing")
    assert not (tmp_path / "folds").exists()


def test_a_folder_has_one_dataset_at_a_time(tmp_path: Path) -> None:
    command = ["dataset", str(written(tmp_path, 1)), "--workers", "1", "--out", str(tmp_path / "folds")]
    with DatasetFolder(tmp_path / "folds").locked():
        ended_with(tatamu(*command), f"{tmp_path / 'folds'}: another dataset is being made here")


def test_a_full_disk_is_one_line(tmp_path: Path) -> None:
    with files_of(10_000):
        ended = tatamu("dataset", str(written(tmp_path, 1)), "--workers", "1", "--out", str(tmp_path / "folds"))
    ended_with(ended, ".npz: cannot be written (File too large)")
    assert not list(tmp_path.rglob("*.tmp"))


def test_a_dataset_of_another_version_is_one_line(made: Path, tmp_path: Path) -> None:
    shutil.copytree(made, tmp_path / "folds")
    file = tmp_path / "folds/dataset.json"
    file.write_text(file.read_text().replace('"version": 1', '"version": 2', 1))
    ended_with(tatamu("replay", str(tmp_path / "folds"), "0"), f"{file}: version: must be 1, given 2")
    again = tatamu("dataset", str(written(tmp_path, 1)), "--workers", "1", "--out", str(tmp_path / "folds"))
    ended_with(again, f"{file}: version: must be 1, given 2")


@pytest.mark.slow
def test_a_dataset_that_is_killed_again_and_again_has_the_same_bytes(tmp_path: Path) -> None:
    """Each time, kill -9 comes as soon as one more episode is kept and the next one is being written."""
    file = written(tmp_path, 8)
    whole = make_dataset(file, tmp_path / "whole")
    out = DatasetFolder(tmp_path / "folds")
    command = [sys.executable, "-m", "tatamu", "dataset", str(file), "--workers", "2", "--out", str(out.path)]
    kills = 0
    while not out.is_finished:
        before = set(out.path.glob(".episodes/*"))
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            while process.poll() is None:
                new = set(out.path.glob(".episodes/*.npz*")) - before
                if len(new) > 1:  # one is kept, the next one is being written
                    process.send_signal(signal.SIGKILL)
                    kills += 1
                    break
                time.sleep(0.001)
            _, said = process.communicate()
        assert process.returncode in (0, -signal.SIGKILL), said
    assert kills >= 2
    assert bytes_in(whole.path) == bytes_in(out.path)
    assert not replay(out.path, 7).differs
