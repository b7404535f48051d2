"""One plan for all tests that only read it: planning takes seconds."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.robots.folds import folder

if TYPE_CHECKING:
    from tatamu.robots import RobotPlan

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


@pytest.fixture(scope="session")
def near_plan(fold: Path) -> RobotPlan:
    """A plan of HIRONX at x = 0.28 m, over a table 6 cm lower."""
    from tatamu.robots import load, plan_fold

    return plan_fold(fold, load("hironx"), place=(0.28, 0.0, 0.0), table_height=-0.06)


@pytest.fixture(scope="session")
def panda_plan(tmp_path_factory: pytest.TempPathFactory) -> RobotPlan:
    """A plan of two Pandas at x, y, yaw = 0."""
    from tatamu.robots import load, plan_fold

    learned = folder(tmp_path_factory.mktemp("panda") / "fold", span=0.5, width=0.4)
    return plan_fold(learned, load("panda-pair"), place=(0.0, 0.0, 0.0))
