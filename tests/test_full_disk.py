"""A disk that fills: one line, finished trials are kept, and the same command goes on.

A limit on the size of files stands for it: it fails in the middle of a write, as a full disk does.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tatamu.base.errors import UnavailableError
from tatamu.base.files import write_text
from tatamu.sweep import SweepFolder, SweepTask, run_sweep
from tests.fabricated import write_fold
from tests.small_studies import learn_plain, timeless
from tests.small_studies import towel as coarse_towel

resource = pytest.importorskip("resource", reason="limits are of POSIX")
pytestmark = pytest.mark.skipif(sys.platform == "darwin", reason="macOS ends a process that passes its limit")


@contextmanager
def files_of(most: int) -> Iterator[None]:
    """No file may grow beyond so many bytes while the block runs."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("calm")
    learn_plain(coarse_towel(), folder, trials=2, baselines=False)
    return folder


@pytest.mark.parametrize(
    ("most", "file"),
    [(0, "study.db"), (20_000, "study.db"), (110_000, "study.db"), (150_000, "rollout.npz"), (250_000, "report.html")],
)
def test_a_study_goes_on_after_the_disk_was_full(undisturbed: Path, tmp_path: Path, most: int, file: str) -> None:
    task = coarse_towel()
    with files_of(most), pytest.raises(UnavailableError, match=file) as stopped:
        learn_plain(task, tmp_path, trials=2, baselines=False)
    assert "\n" not in str(stopped.value) and "remove" not in str(stopped.value)
    assert not (tmp_path / "report.html").exists()
    assert not list(tmp_path.glob("*.tmp"))
    learn_plain(task, tmp_path, trials=2, baselines=False)
    assert timeless(tmp_path) == timeless(undisturbed)


def test_a_commit_that_finds_the_disk_full_does_not_call_the_study_unreadable(tmp_path: Path) -> None:
    from sqlite3 import OperationalError

    from optuna.exceptions import StorageInternalError

    from tatamu.study.folder import ResultFolder
    from tatamu.study.store import file_store

    def commits() -> None:
        try:
            raise OperationalError("database or disk is full")
        except OperationalError as error:
            raise StorageInternalError("An exception is raised during the commit.") from error

    with pytest.raises(UnavailableError, match="the disk is full; finished trials are kept"):
        with file_store(ResultFolder(tmp_path)) as store:
            store.run(commits)


def test_a_sweep_ends_and_keeps_what_was_finished(tmp_path: Path) -> None:
    tasks = [SweepTask(name, {"garment": "towel"}) for name in ("first", "second", "third")]
    folder = SweepFolder(tmp_path / "out")

    def learned(options: dict[str, Any], path: Path, progress: Callable[[Any], None]) -> None:
        write_fold(path, spacing=0.08, frames=6)
        with files_of(10**9 if path.name == "first" else 500):
            write_text(path / "report.html", 1_000 * "-")

    with pytest.raises(UnavailableError, match="second"):
        run_sweep(tasks, folder, learned)
    assert [record.state for record in folder.read()] == ["complete", "waiting", "waiting"]
    assert not list((tmp_path / "out").rglob("*.tmp"))
