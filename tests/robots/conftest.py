"""One plan for all tests that only read it: planning takes seconds."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from tests.robots.folds import folder

if sys.platform == "linux" and "DISPLAY" not in os.environ:
    os.environ.setdefault("MUJOCO_GL", "egl")


@pytest.fixture(scope="session")
def fold(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a learned fold that HIRONX can do."""
    return folder(tmp_path_factory.mktemp("learned") / "fold")


@pytest.fixture(scope="session")
def plan_folder(fold: Path) -> Path:
    """The folder of HIRONX's plan for it."""
    from tatamu.robots import load, plan_fold, save

    save(plan_fold(fold, load("hironx")), fold.parent / "plan")
    return fold.parent / "plan"
