"""Checks that a plan must pass before it is written.

A check has the worst value during the motion, the limit of this value, and the time at which the worst value occurs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple, replace

import numpy as np
from numpy.typing import ArrayLike

from tatamu.folding.fingers import PAD
from tatamu.robots.arm import MIN_HELD
from tatamu.robots.clearance import Clearance
from tatamu.robots.cloth import nearest_cloth
from tatamu.robots.motion import Motion
from tatamu.robots.pairs import CLOTH, DISTANCES, KINDS
from tatamu.robots.paths import Paths, PlacedFold, tool_poses
from tatamu.robots.planfile import PlanCheck
from tatamu.robots.pose import into, rotation_vector
from tatamu.robots.stage import touches

EVERY = 4
"""Number of samples of the robot's motion from one computation of distances between links to the next.

There are 50 computations a second. In addition, MuJoCo tests at every sample whether shapes come too near.
"""
MIN_MARGIN = 0.01
"""Minimum distance of a joint from its limits [rad]."""
MIN_SINGULARITY = 0.03
"""Minimum singular value of an arm's Jacobian; see `Chain.singularity`."""
PATH_ERROR = 1e-3
"""Maximum distance of a tool from its path, which follows the hand's Bezier curve [m]."""
TURN_ERROR = 5e-3
"""Maximum rotation of a tool from its orientation at the grasp [rad]."""
MAX_SLOWING = 5.0
"""Maximum ratio of the fold's duration on the robot to its simulated duration.

A slower motion would make another fold than the simulated fold. If the user asks for a slower plan, for example at half
the speed, the limit is raised accordingly.
"""
UNDERNEATH = 0.003
"""Maximum height of the lower finger above the table when the jaws start to close [m]."""
ASKEW = 5e-3
"""Tolerance by which the angle of the jaws about the vertical may exceed `Jaw.yaw` [rad]."""


class Checks:
    """The checks of one motion of the robot."""

    def __init__(self, task: PlacedFold, paths: Paths, motion: Motion) -> None:
        self._task, self._paths, self._motion = task, paths, motion
        self._fold = motion.rows("fold")
        self._tools = tool_poses(task.robot, paths.chains, motion.angles)

    def all(self) -> dict[str, PlanCheck]:
        """Return the results of all checks, by the names of the checks."""
        return {
            "joint_limit_margin": self._margin(),
            "joint_speed": self._rate("rad/s", 1),
            "joint_acceleration": self._rate("rad/s^2", 2),
            **self._tool_checks(),
            **self._grasps(),
            **self._distances(),
            "singularity": self._singularity(),
            "time_scaling": self._scaling(),
        }

    def _at(self, row: int) -> tuple[str, int]:
        """Return the time of a motion sample as text, and the number of the simulation's frame at this time."""
        motion = self._motion
        time = motion.times[row]
        part = [part for part in motion.parts if part.start <= time + 1e-9][-1]
        if part.name != "fold":
            before = part.start < motion.part("fold").start
            frame = self._task.hands.frame(float(self._task.hands.times[0 if before else -1]))
            return f"at frame {frame}, while the robot does '{part.name}' ({time:.2f} s)", frame
        frame = self._task.hands.frame(float(motion.simulated(np.array([row]))[0]))
        return f"at frame {frame} ({time:.2f} s)", frame

    def _check(self, value: float, limit: float, unit: str, row: int, what: str = "", least: bool = False) -> PlanCheck:
        where, frame = self._at(row)
        return PlanCheck(
            value=float(value),
            limit=float(limit),
            unit=unit,
            ok=bool(value >= limit if least else value <= limit),
            where=f"{what} {where}".strip(),
            frame=frame,
        )

    def _worst(
        self,
        values: ArrayLike,
        limit: float,
        unit: str,
        least: bool = False,
        rows: np.ndarray | None = None,
    ) -> PlanCheck:
        """Check the worst of all arms' values, shape (arms, n), at samples of the motion, by default of the fold."""
        found, rows = np.asarray(values), self._fold if rows is None else rows
        arm, column = np.unravel_index(int(found.argmin() if least else found.argmax()), found.shape)
        name = self._task.robot.folding[arm].name
        return self._check(found[arm, column], limit, unit, int(rows[column]), name, least)

    def _margin(self) -> PlanCheck:
        model, q = self._task.robot.model, self._motion.angles
        names = [name for name in self._task.robot.joints if model.joint(name).limited[0]]
        columns = [self._task.robot.columns[name] for name in names]
        low, high = np.array([model.joint(name).range for name in names]).T
        room = np.minimum(q[:, columns] - low, high - q[:, columns])
        row, joint = np.unravel_index(int(room.argmin()), room.shape)
        return self._check(room.min(), MIN_MARGIN, "rad", int(row), names[joint], least=True)

    def _rate(self, unit: str, order: int) -> PlanCheck:
        """Check the joint whose speed or acceleration is nearest to its limit."""
        names, columns = zip(*self._task.robot.columns.items(), strict=True)
        limits = self._task.robot.planned()[order - 1][list(columns)]
        rate = np.abs(np.diff(self._motion.angles[:, columns], n=order, axis=0)) / self._motion.times[1] ** order
        row, column = np.unravel_index(int((rate / limits).argmax()), rate.shape)
        return self._check(rate[row, column], limits[column], unit, int(row), names[column])

    def _tool_checks(self) -> dict[str, PlanCheck]:
        """Check that the tools follow the hands' curves, keep their orientation, and are not faster than the hands."""
        task, tools = self._task, self._tools[:, self._fold]
        offsets = np.array([offset for _, offset, _ in task.grips])
        p_FT = into(task.placement.matrix, tools[:, :, :3, 3] - offsets[:, None])
        error = [curve.nearest(points)[1] for curve, points in zip(task.hands.curves, p_FT, strict=True)]
        turned = [
            np.linalg.norm(rotation_vector(R_BT.T @ X_BT[:, :3, :3]) * chain.turn_weights, axis=1)
            for X_BT, (R_BT, _, _), chain in zip(tools, task.grips, self._paths.chains, strict=True)
        ]
        speed = np.linalg.norm(np.diff(tools[:, :, :3, 3], axis=1), axis=2) / self._motion.times[1]
        return {
            "tool_path_error": self._worst(error, PATH_ERROR, "m"),
            "tool_turn_error": self._worst(turned, TURN_ERROR, "rad"),
            "tool_speed": self._worst(speed, 1.005 * task.hands.top_speed, "m/s"),
        }

    def _grasps(self) -> dict[str, PlanCheck]:
        """Check how the hands grasp the edges of the cloth. If two hands fold, the worse hand counts."""
        closes, arms = self._motion.rows("close")[:1], self._task.robot.folding
        depth, held, lowest, askew = np.array([*_grasps(self._task, self._tools[:, closes[0]])]).T[..., None]
        opening, widest = [[arm.jaw.opening] for arm in arms], min(arm.jaw.widest for arm in arms)
        yaw = max(arm.jaw.yaw for arm in arms) + ASKEW
        return {
            "hem_in_the_open_jaw": self._worst(depth, PAD, "m", least=True, rows=closes),
            "cloth_in_the_closed_jaw": self._worst(held, MIN_HELD, "m", least=True, rows=closes),
            "lower_finger_under_the_hem": self._worst(lowest, UNDERNEATH, "m", rows=closes),
            "jaw_across_the_hem": self._worst(askew, yaw, "rad", rows=closes),
            "jaw_opening": self._worst(opening, widest, "m", rows=closes),
        }

    def _distances(self) -> dict[str, PlanCheck]:
        robot, height, angles = self._task.robot, self._task.table, self._motion.angles
        some = Clearance(robot, table=height).least(angles[::EVERY])
        found = {kind: replace(distance, row=distance.row * EVERY) for kind, distance in some.items()}
        for kind, touch in touches(robot, height, angles).items():
            if kind not in found or touch.value < found[kind].value:
                found[kind] = touch
        if self._task.cloth is not None:
            found[CLOTH] = nearest_cloth(self._task, self._motion, self._tools, self._task.cloth)
        checks = {}
        for kind in filter(found.__contains__, (*KINDS, CLOTH)):
            value, row, pair = astuple(found[kind])
            links = " and ".join(filter(None, pair))
            allowed = DISTANCES[kind].allowed
            checks[f"distance_{kind.replace(' ', '_')}"] = self._check(value, allowed, "m", row, links, least=True)
        return checks

    def _singularity(self) -> PlanCheck:
        robot, angles = self._task.robot, self._motion.angles[self._fold]
        arms = zip(self._paths.chains, robot.folding, strict=True)
        worst = [chain.singularity(angles[:, robot.arm_columns(arm)]) for chain, arm in arms]
        return self._worst(worst, MIN_SINGULARITY, "1", least=True)

    def _scaling(self) -> PlanCheck:
        """Check that the robot is not too slow: the fold's duration on the robot, divided by its simulated duration."""
        times, fold = self._task.hands.times, self._motion.part("fold")
        rate = np.diff(self._motion.simulated(self._fold)) / self._motion.times[1]
        slowest = int(self._fold[int(rate.argmin())]) if len(rate) else int(self._fold[0])
        value = fold.timed.duration / float(times[-1] - times[0])
        return self._check(value, MAX_SLOWING / self._motion.speed_scale, "1", slowest, "slowest")


def _grasps(task: PlacedFold, tools: np.ndarray) -> Iterator[tuple[float, float, float, float]]:
    """Yield the grasp of each hand from the poses X_BT of the arms' tools when the jaws start to close.

    See docs/theory/grasp.md. The values are the distance from the cloth's edge to the place where the fingertips will
    meet [m], the depth to which the cloth is between the fingertips after the jaw has closed [m], the height of the
    lower finger of the open jaw above the table [m], and the angle by which the jaw deviates from the plane at right
    angles to the cloth's edge, seen from above [rad].
    """
    X_BF = task.placement.matrix
    for arm, curve, X_BT in zip(task.robot.folding, task.hands.curves, tools, strict=True):
        control, jaw = curve.control, arm.jaw
        across = X_BF[:2, :2] @ (control[-1] - control[0])[:2]
        across = across / np.linalg.norm(across)
        hem = X_BF[:3, :3] @ (control[0] * [1.0, 1.0, 0.0]) + X_BF[:3, 3]
        opening = X_BT[:3, 1] * (1.0 if X_BT[2, 1] >= 0 else -1.0)
        seen = opening[:2] / max(float(np.linalg.norm(opening[:2])), 1e-9)
        depth, height = float((X_BT[:3, 3] - hem)[:2] @ across), float(X_BT[2, 3] - hem[2])
        lowest = height - (jaw.opening / 2 + jaw.thickness) * float(opening[2])
        askew = float(np.arccos(np.clip(seen @ across, -1.0, 1.0)))
        yield depth, jaw.held(depth, height), lowest, askew


def in_words(value: float, limit: float, unit: str, ok: bool) -> tuple[str, str, str]:
    """Return three texts for a checked value: the value, its unit and its limit.

    Metres are converted to millimetres.
    """
    scale, unit = (1e3, "mm") if unit == "m" else (1.0, "" if unit == "1" else unit)
    bound = "at least" if ok == (value > limit) else "at most"
    return f"{scale * value:.4g}", unit, f"{bound} {scale * limit:.4g}"


def failing(checks: dict[str, PlanCheck]) -> tuple[str, PlanCheck] | None:
    """Return the name of the first check that failed, and the check; None if all checks passed."""
    return next(((name, check) for name, check in checks.items() if not check.ok), None)
