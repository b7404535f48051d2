"""What several files of tests begin with."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.browser import chromium, phone
from tests.fabricated import write_fold

__all__ = ["chromium", "phone"]

settings.register_profile("any machine", deadline=None)  # a busy machine is no fault
settings.load_profile("any machine")


@pytest.fixture(scope="session", autouse=True)
def _small_pictures() -> Iterator[None]:
    """Views from above of a few pixels: drawing them is most of a report's time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tatamu.report.topview.WIDE", 120)
        yield


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A learned fold of a few vertices and frames."""
    return write_fold(tmp_path / "towel", spacing=0.08, frames=24)
