"""Compiled kernels are forgotten when a source that they contain has changed, and only then."""

from __future__ import annotations

from pathlib import Path

import pytest

from tatamu.simulators.native import cache


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "step.py").write_text("calls = 'contact'")
    (tmp_path / "contact.py").write_text("friction = 1")
    (tmp_path / "__pycache__").mkdir()
    monkeypatch.setattr(cache, "FOLDER", tmp_path)
    cache.forget_stale_kernels()
    (tmp_path / "__pycache__" / "step.nbi").write_text("compiled")
    return tmp_path


def test_kernels_of_the_same_sources_are_kept(folder: Path) -> None:
    cache.forget_stale_kernels()
    assert (folder / "__pycache__" / "step.nbi").exists()


def test_kernels_are_forgotten_when_another_file_changes(folder: Path) -> None:
    (folder / "contact.py").write_text("friction = 2")
    cache.forget_stale_kernels()
    assert not (folder / "__pycache__" / "step.nbi").exists()
