"""Small towels and quick studies that several tests use."""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from tatamu import (
    LearnOptions,
    Nominal,
    Progress,
    Result,
    Scenarios,
    Task,
    learn,
    make_task,
)
from tatamu.evaluation.disturbances import default_disturbances
from tatamu.study.database import SharedDatabase

COARSE: dict[str, Any] = {"spacing": 0.04, "size": (0.24, 0.5)}
"""A towel of a hundred vertices."""
X: dict[str, int | float] = {"x1": 0.05, "z1": 0.2, "x2": 0.4, "z2": 0.1, "g1": 0, "g2": 0}
"""A manipulation of it."""
SECONDS = ("seconds", "wall_seconds", "setup_seconds")


def towel(**changes: Any) -> Task:
    """The towel, to be folded in half."""
    return make_task("towel", **{**COARSE, **changes})


def plain(**changes: Any) -> LearnOptions:
    """Options of the paper's search: one mesh, and nothing disturbed."""
    return LearnOptions(**{"disturbances": "none", **changes})


def learn_plain(
    task: Task,
    out: Path | None,
    executor: Executor | None = None,
    database: SharedDatabase | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
    **options: Any,
) -> Result:
    """Learn a fold without disturbances."""
    result = learn(task, plain(**options), out=out, executor=executor, database=database, progress=progress)
    assert isinstance(result, Result)
    return result


def over_scenarios(task: Task) -> Scenarios:
    """The scenarios of the default disturbances."""
    return Scenarios(Nominal(task), default_disturbances())


def bytes_in(folder: Path) -> dict[str, bytes]:
    """What the files of a folder contain, by their paths inside."""
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def without_times(value: Any) -> Any:
    """Plain data without its times."""
    if isinstance(value, dict):
        return {name: without_times(each) for name, each in value.items() if name not in SECONDS}
    return [without_times(each) for each in value] if isinstance(value, list) else value


def timeless(folder: Path) -> str:
    """Every result.json of a folder, without its times."""
    return json.dumps([without_times(json.loads(file.read_text())) for file in sorted(folder.rglob("result.json"))])
