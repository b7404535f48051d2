"""Blender over a long day: many scenes, sudden deaths, two studies at once."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.api import learn
from tatamu.folding.task import make_task
from tatamu.simulation.blender import process, simulate
from tatamu.simulation.blender.process import Worker
from tatamu.study.options import LearnOptions
from tests.scenes import scene, sheet
from tests.test_other_simulators import needs_blender

pytestmark = [needs_blender, pytest.mark.skipif(not Path("/proc").exists(), reason="reads /proc")]

PLAIN = LearnOptions(trials=2, disturbances="none", baselines=False)
SMALL: dict[str, Any] = {"size": (0.2, 0.3), "spacing": 0.02, "simulator": "blender"}


def children() -> dict[int, str]:
    """Process id and state of every Blender that we started; Z: a zombie."""
    found = {}
    for entry in Path("/proc").iterdir():
        try:
            _, rest = (entry / "stat").read_text().rsplit(")", 1)
            words = (entry / "cmdline").read_bytes().decode()
        except (OSError, ValueError):
            continue
        state, parent = rest.split()[:2]
        if int(parent) == os.getpid() and ("worker.py" in words or state == "Z"):
            found[int(entry.name)] = state
    return found


def measured(folder: Path) -> list[dict[str, Any]]:
    """The trials of a study without their times."""
    trials = json.loads((folder / "result.json").read_text())["trials"]
    return [{key: value for key, value in trial.items() if key != "seconds"} for trial in trials]


def test_a_blender_that_is_ended_leaves_no_folder_and_no_zombie() -> None:
    before = set(Path(tempfile.gettempdir()).glob("tatamu-blender-*"))
    worker = Worker()
    assert len(set(Path(tempfile.gettempdir()).glob("tatamu-blender-*")) - before) == 1
    worker.close()
    assert set(Path(tempfile.gettempdir()).glob("tatamu-blender-*")) == before
    assert worker.process.pid not in children()


@pytest.mark.slow
def test_a_thousand_scenes_are_one_process() -> None:
    short = scene(cloth=sheet(0.1, 0.2), duration=0.05)
    first = simulate(short)
    begun = children()
    for _ in range(999):
        assert np.array_equal(simulate(short).positions[-1], first.positions[-1])
    assert children() == begun or set(children()) == set(begun)
    assert "Z" not in children().values()


@pytest.mark.slow
def test_a_blender_killed_in_the_middle_of_a_trial_loses_nothing(tmp_path: Path) -> None:
    learn(make_task("towel", **SMALL), PLAIN, out=tmp_path / "quiet")
    kills = []

    def kill() -> None:
        for pid in children():
            os.kill(pid, signal.SIGKILL)
            kills.append(pid)

    timers = [threading.Timer(delay, kill) for delay in (1.0, 6.0)]
    for timer in timers:
        timer.start()
    learn(make_task("towel", **SMALL), PLAIN, out=tmp_path / "killed")
    for timer in timers:
        timer.cancel()
    assert kills, "nothing was killed: the trials are shorter than the test thinks"
    assert measured(tmp_path / "killed") == measured(tmp_path / "quiet")
    assert "Z" not in children().values()


@pytest.mark.slow
def test_two_studies_use_blender_at_once(tmp_path: Path) -> None:
    code = (
        "import sys; from tatamu.api import learn; from tests.test_blender_robustness import PLAIN, SMALL; "
        "from tatamu.folding.task import make_task; learn(make_task('towel', **SMALL), PLAIN, out=sys.argv[1])"
    )
    both = [subprocess.Popen([sys.executable, "-c", code, str(tmp_path / name)]) for name in ("one", "two")]
    assert [study.wait() for study in both] == [0, 0]
    assert measured(tmp_path / "one") == measured(tmp_path / "two")


@pytest.fixture(autouse=True, scope="module")
def _ended() -> Any:
    yield
    process.WORKERS.close()
    deadline = time.monotonic() + 300.0
    while children() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not children()
