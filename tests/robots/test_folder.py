"""A plan's folder is replaced as a whole: a kill at any moment leaves the earlier plan or the new one, never a part."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

pytest.importorskip("mujoco")

from tatamu.robots.folder import replacing_folder

KILLED = 9
STEPS = ("os.rename", "os.remove", "os.rmdir", "os.mkdir", "os.chmod")
"""Events of Python before a step that changes a folder."""


def replace_until(out: Path, steps: int) -> int:
    """Write a plan in a process that dies after this number of steps, and return its exit code."""
    process = os.fork()
    if process:
        return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    left = steps

    def step(event: str, _: object) -> None:
        nonlocal left
        left -= event in STEPS
        if left < 0:
            os._exit(KILLED)

    sys.addaudithook(step)
    with replacing_folder(out) as folder:
        for name in ("plan.json", "goals.json", "robot.xml"):
            (folder / name).write_text("new")
    os._exit(0)


def contents(folder: Path) -> list[str]:
    return sorted(file.read_text() for file in folder.iterdir())


def earlier(out: Path) -> Path:
    out.mkdir(parents=True)
    for name in ("plan.json", "goals.json", "robot.xml"):
        (out / name).write_text("old")
    return out


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")  # the process has threads, but the child needs none
@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no fork")
def test_a_kill_at_any_moment_leaves_a_whole_plan(tmp_path: Path) -> None:
    for moments in range(99):
        out = earlier(tmp_path / f"{moments}" / "plan")
        ended = replace_until(out, moments)
        assert ended in (0, KILLED)
        if ended == 0:
            break
        if out.exists():
            assert contents(out) in (["old"] * 3, ["new"] * 3)
        else:
            assert ["old"] * 3 in [contents(folder) for folder in out.parent.glob(".tatamu-*/*")]
    assert moments >= 6 and contents(out) == ["new"] * 3
    assert list(out.parent.iterdir()) == [out]


def test_an_interruption_between_the_two_renames_keeps_the_earlier_plan(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = earlier(tmp_path / "plan")
    renamed = Path.rename

    def interrupted(self: Path, target: Path) -> Path:
        if target == out and self.name == "new":
            raise KeyboardInterrupt
        return renamed(self, target)

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt), replacing_folder(out) as folder:
        (folder / "plan.json").write_text("new")
    assert contents(out) == ["old"] * 3 and list(tmp_path.iterdir()) == [out]
