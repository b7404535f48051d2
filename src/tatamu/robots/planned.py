"""Read those files of a plan's folder that a rehearsal needs."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import read_json, read_text, validated
from tatamu.robots.planfile import PlanFile
from tatamu.study.folder import ResultFolder

ARMS = ("larm", "rarm")
FOLD = "fold"
"""Folder of the learned fold inside the plan's folder."""

MAX_DURATION = 3600.0
"""Longest duration of a valid plan [s]."""
MAX_ANGLE = 100.0
"""Maximum angle of a joint in a valid plan [rad]."""


@dataclass(frozen=True)
class Planned:
    """A plan that has been read from its folder."""

    folder: Path
    plan: PlanFile
    times: np.ndarray
    """Times of the samples [s], shape (n,)."""
    angles: np.ndarray
    """Angles of the j joints in `plan.joints` at each sample [rad], shape (n, j)."""

    @classmethod
    def load(cls, folder: Path) -> Planned:
        """Read the files plan.json and joint_trajectory.csv of a plan's folder.

        Raises:
            InputError: If a file is missing or wrong.
        """
        if not folder.is_dir():
            raise InputError(f"{folder}: must be the folder of a plan, but is not a folder")
        path = folder / "plan.json"
        if not path.exists():
            raise InputError(f"{folder}: must be the folder of a plan, but has no plan.json")
        plan = validated(PlanFile, read_json(path), path)
        _check_events(path, plan)
        table = folder / "joint_trajectory.csv"
        times, angles = _table(table, plan.joints)
        if times[-1] < max((event.time for event in plan.events), default=0.0):
            raise InputError(f"{table}: ends at {times[-1]:.2f} s, before the last event of plan.json")
        planned = cls(folder, plan, times, angles)
        if any(planned.event(arm, "open") <= planned.event(arm, "close") for arm in planned.arms):
            raise InputError(f"{path}: events: must let each arm close before it opens")
        return planned

    @property
    def arms(self) -> tuple[str, ...]:
        """Names of the arms that fold, the left arm first."""
        return _arms(self.plan)

    @property
    def fold(self) -> ResultFolder:
        """Folder of the learned fold inside the plan's folder. Some of its files may be missing."""
        return ResultFolder(self.folder / FOLD)

    def fingers(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """Return the positions of the finger joints at n times [s], by the names of the joints.

        The fingers are open at first, then closed, then open again.
        """
        lasting = {stage.name: stage.duration for stage in self.plan.stages}
        found: dict[str, np.ndarray] = {}
        for arm, jaw in self.plan.jaws.items():
            if arm in self.arms:
                close, opening = (self.event(arm, event) for event in ("close", "open"))
                knots = [close, close + lasting.get("close", 0.0), opening, opening + lasting.get("open", 0.0)]
                closed = np.interp(times, np.maximum.accumulate(knots), [0.0, 1.0, 1.0, 0.0])
                found |= {name: start + closed * (end - start) for name, (start, end) in jaw.fingers.items()}
        return found

    def event(self, arm: str, event: str) -> float:
        """Return the time at which an arm's fingers close or open [s].

        The fingers stay open if the plan only hovers above the table. In this case, return the time at which they would
        close or open.
        """
        if self.plan.hover:
            return self.plan.segments[("close", "open").index(event)].end
        return next(found.time for found in self.plan.events if (found.arm, found.event) == (arm, event))


def _arms(plan: PlanFile) -> tuple[str, ...]:
    """Return the names of the arms that fold."""
    named = set(plan.jaws) if plan.hover else {event.arm for event in plan.events}
    return tuple(arm for arm in ARMS if arm in named)


def _check_events(path: Path, plan: PlanFile) -> None:
    """Raise an error if a hand of the plan does not close exactly once and open exactly once."""
    if plan.hover:
        if [segment.name for segment in plan.segments] != ["approach", "fold", "leave"]:
            raise InputError(f"{path}: segments: must be approach, fold and leave in a plan that hovers")
    elif not plan.events or sorted((event.arm, event.event) for event in plan.events) != [
        (arm, event) for arm in _arms(plan) for event in ("close", "open")
    ]:
        raise InputError(f"{path}: events: must contain one close and one open for each arm that folds")


def _table(path: Path, joints: list[str]) -> tuple[np.ndarray, np.ndarray]:
    try:
        rows = list(csv.reader(io.StringIO(read_text(path))))
    except csv.Error as error:
        raise InputError(f"{path}: must be a table of numbers ({error})") from None
    if not rows or rows[0] != ["time", *joints]:
        raise InputError(f"{path}: header: must be time and the joints of plan.json")
    try:
        table = np.array(rows[1:], dtype=float)
    except ValueError:
        raise InputError(f"{path}: must contain a number in every field") from None
    if table.ndim != 2 or len(table) < 2 or not np.isfinite(table).all():
        raise InputError(f"{path}: must contain at least two rows of finite numbers")
    times, angles = table[:, 0], table[:, 1:]
    if not (times[0] >= 0 and times[-1] <= MAX_DURATION and (times[1:] > times[:-1]).all()):
        raise InputError(f"{path}: time: must increase from row to row, from 0 to at most {MAX_DURATION:g} s")
    if not np.abs(angles).max(initial=0.0) <= MAX_ANGLE:
        row, column = np.unravel_index(int(np.abs(angles).argmax()), angles.shape)
        raise InputError(
            f"{path}: {joints[column]}: must be within {MAX_ANGLE:g} rad, given {angles[row, column]:.4g} at "
            f"{times[row]:g} s"
        )
    return times, angles
