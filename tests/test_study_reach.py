"""What no robot reaches is said before the first trial."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import InputError, LearnOptions, Task, learn, make_task
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Reach

TOO_FAR = "larm cannot follow its hand beyond frame 6"


class Short:
    """A robot with the hands at its sides: it does folds of so many metres."""

    def __init__(self, reach: float) -> None:
        self.reach, self.asked = reach, 0

    def quality(self, manipulation: Manipulation) -> float:
        points = manipulation.curves[0].control
        return self.reach - float(np.linalg.norm(points[3] - points[0]))

    def refusal(self, manipulation: Manipulation) -> str | None:
        self.asked += 1
        return None if self.quality(manipulation) >= 0 else TOO_FAR


def task(robot: Short, fold: str = "half", **changes: Any) -> Task:
    reach = Reach("short", quality=robot.quality, refusal=robot.refusal)
    return make_task("towel", **{"fold": fold, "spacing": 0.04, "size": (0.24, 0.5), "reach": reach, **changes})


TWO = LearnOptions(trials=2, disturbances="none", baselines=False)


LENGTHWISE = "in half along the length"
PRESSED = '[[step]]\nline = [[0.0, -0.5], [0.0, 0.5]]\nmoves = "-x"\npress = {weight = 5.0}\n'


@pytest.mark.parametrize(
    ("reach", "fold", "changes", "says"),
    [
        pytest.param(
            0.3, "half", {}, f"robot: must be able to carry out the fold in half across.*short.*{TOO_FAR}", id="fold"
        ),
        pytest.param(
            0.4,
            "quarters",
            {"size": (0.5, 0.36)},
            f"robot: must be able to carry out step 2, {LENGTHWISE}, but short",
            id="step",
        ),
        pytest.param(1.0, "pressed.toml", {}, "press: short cannot press the fold pressed; leave", id="press"),
    ],
)
def test_a_fold_that_a_robot_cannot_do_is_refused_and_nothing_is_written(
    reach: float, fold: str, changes: dict[str, Any], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pressed.toml").write_text(PRESSED)
    with pytest.raises(InputError, match=says):
        learn(task(Short(reach), fold, **changes), TWO, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_what_is_within_reach_is_asked_before_a_study_starts_and_not_again(tmp_path: Path) -> None:
    robot = Short(1.0)
    for asked in (1, 1):
        learn(task(robot), TWO, out=tmp_path)
        assert robot.asked == asked
