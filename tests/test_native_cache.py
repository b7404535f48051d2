"""Compiled kernels are forgotten when a source that they contain has changed, and only then."""

from __future__ import annotations

from pathlib import Path

import pytest

import tatamu.simulators.native
from tatamu.simulators.native.memory.kernel_cache import NATIVE, forget_stale_kernels


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
    assert Path(tatamu.simulators.native.__file__).parent == NATIVE
    assert {"contact", "elastic", "memory"} <= {file.parent.name for file in NATIVE.rglob("*.py")}
