"""Compiled kernels are forgotten when a source that they contain has changed, and only then."""

from __future__ import annotations

import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from numba import typeof

import tatamu.simulation.native
from tatamu.simulation.native import compiled, precompile
from tatamu.simulation.native.memory.kernel_cache import NATIVE, forget_stale_kernels
from tatamu.simulation.native.precompile import Unsearched, calls, compile_but_search, compiling_beside, smallest_scene
from tatamu.simulation.native.simulator import load_kernels


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Sources in two rooms, each with a compiled kernel."""
    (tmp_path / "step.py").write_text("calls = 'contact'")
    (tmp_path / "contact").mkdir()
    (tmp_path / "contact" / "table.py").write_text("friction = 1")
    forget_stale_kernels(tmp_path)
    for kernel in _kernels(tmp_path):
        kernel.parent.mkdir(exist_ok=True)
        kernel.write_text("compiled")
    return tmp_path


def _kernels(folder: Path) -> list[Path]:
    return [folder / "__pycache__" / "step.nbi", folder / "contact" / "__pycache__" / "table.1.nbc"]


def test_kernels_of_the_same_sources_are_kept(folder: Path) -> None:
    forget_stale_kernels(folder)
    assert all(kernel.exists() for kernel in _kernels(folder))


@pytest.mark.parametrize("source", ["step.py", "contact/table.py"])
def test_kernels_of_all_rooms_are_forgotten_when_a_file_of_any_changes(folder: Path, source: str) -> None:
    (folder / source).write_text("friction = 2")
    forget_stale_kernels(folder)
    assert not any(kernel.exists() for kernel in _kernels(folder))


def test_kernels_are_forgotten_when_a_file_moves_to_another_room(folder: Path) -> None:
    (folder / "contact" / "table.py").rename(folder / "contact.py")
    forget_stale_kernels(folder)
    assert not any(kernel.exists() for kernel in _kernels(folder))


def test_the_folder_that_is_looked_at_is_that_of_the_simulator() -> None:
    assert Path(tatamu.simulation.native.__file__).parent == NATIVE
    assert {"contact", "elastic", "memory"} <= {file.parent.name for file in NATIVE.rglob("*.py")}


def test_what_a_second_process_compiles_is_what_time_stepping_calls() -> None:
    """Another signature would be compiled in vain, and would lie on disk beside the one that is called.

    What lies on disk is looked at, not what this process compiled: where two begin without kernels, both compile some.
    Tests that compile kernels for double precision, as time stepping does not, do not count.
    """
    load_kernels()
    compile_but_search()
    for kernel, arguments in calls(Unsearched(smallest_scene()).system):
        kept = {signature for signature, *_ in kernel._cache._cache_file._load_index()}
        others = [each for each in kept - {tuple(map(typeof, arguments))} if "float32" in str(each)]
        assert not others, f"time stepping calls {kernel.__name__} with other types"


def test_there_is_no_second_process_where_kernels_are_on_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    load_kernels()
    monkeypatch.setattr(subprocess, "Popen", None)
    with compiling_beside():
        pass


def test_a_second_process_that_fails_is_made_up_for_here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(precompile, "COMMAND", "raise SystemExit(1)")
    monkeypatch.setattr(precompile, "processors", lambda: 2)
    begun = []

    class Noted(subprocess.Popen[bytes]):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            begun.append(self)

    monkeypatch.setattr(subprocess, "Popen", Noted)
    with compiling_beside(str(tmp_path)):
        pass
    assert [process.returncode for process in begun] == [1]


def test_what_is_told_of_compiling_counts_what_is_on_disk_and_only_where_this_process_compiles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    load_kernels()
    total = len(compiled._KERNELS)
    monkeypatch.setattr(compiled, "_KERNELS", [fake(each, misses=1) for each in compiled._KERNELS])
    assert compiled.compilation()[1] == total
    assert compiled.compilation()[0] > 0.9 * total, "all but those that untangle layers, which two triangles do not"
    monkeypatch.setattr(compiled, "_KERNELS", [fake(each, misses=0) for each in compiled._KERNELS])
    assert compiled.compilation() == (0, total)


def fake(kernel: Any, misses: int) -> Any:
    """A kernel that says that it was not on disk so many times."""
    stats = SimpleNamespace(cache_path=kernel.stats.cache_path, cache_misses={"signature": misses} if misses else {})
    return SimpleNamespace(py_func=kernel.py_func, __name__=kernel.__name__, stats=stats)
