"""Inverse kinematics along tool paths, for all arms that fold at the same time, by the library mink."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.robots import demand
from tatamu.robots.chain import LENGTH
from tatamu.robots.extras import needed
from tatamu.robots.model import Robot
from tatamu.robots.pose import to_quaternion

REACHED = 2e-6
"""Limit for the error of a tool pose [m]. If the error is smaller, the tool has reached its target pose.

Rotation errors [rad] are converted to metres by the factor `chain.LENGTH` [m per rad].
"""
STEPS = 60
NEAR, ALIGNED = 1e-4, 1e-3
"""Limits for a tool's distance [m] and angle [rad] from its target pose.

Messages about a missed pose report only distances and angles above these limits.
"""


@dataclass(frozen=True)
class Missed:
    """A tool pose that has no solution near the previous pose."""

    point: int
    """Index of the pose on the path."""
    arm: str
    distance: float
    """Distance from the tool to its target position [m]."""
    turn: float
    """Angle between the orientation of the tool and its target orientation [rad]."""
    joint: str | None
    """A joint that is at its limit; None if no joint is at its limit."""

    @property
    def reason(self) -> str:
        """Explanation why the pose has no solution, as text."""
        if self.joint:
            why = f"{self.joint} stands at its limit"
        elif self.distance > NEAR:
            why = "it is out of reach"
        elif self.turn > ALIGNED:
            why = "it gets there and cannot turn its jaw so"
        else:
            why = "its joints cannot move on from there (a singular pose)"
        left = [
            *([f"{1e3 * self.distance:.1f} mm"] if self.distance > NEAR else []),
            *([f"{np.degrees(self.turn):.1f} deg"] if self.turn > ALIGNED else []),
        ]
        return why + (f", {' and '.join(left)} are left" if left else "")


class Kinematics:
    """Solver for joint angles along tool paths.

    Each pose is solved from the solution of the previous pose, inside the joint limits.
    """

    def __init__(self, robot: Robot) -> None:
        mink = needed("mink")
        self._mink, self._robot = mink, robot
        model = robot.model
        moving = {model.joint(name).dofadr[0] for arm in robot.folding for name in arm.joints}
        still = [dof for dof in range(model.nv) if dof not in moving]
        self._counted = [demand.weights(len(arm.joints)) for arm in robot.folding]
        self._tasks = [
            mink.FrameTask(arm.site, "site", position_cost=1.0, orientation_cost=LENGTH * counted)
            for arm, counted in zip(robot.folding, self._counted, strict=True)
        ]
        self._limits = [mink.ConfigurationLimit(model)]
        self._frozen = [mink.DofFreezingTask(model, still)] if still else None
        self._configuration = mink.Configuration(model)
        base = robot.at_rest().body(robot.base)
        self.R_WB, self.p_WB = base.xmat.reshape(3, 3).copy(), base.xpos.copy()

    def path(self, tools: np.ndarray, trunk: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, Missed | None]:
        """Return the full configurations of the robot along the arms' tool poses.

        Args:
            tools: Poses X_BT of the tool T in the base B for each arm that folds, shape (arms, n, 4, 4).
            trunk: Given angle of the trunk at each pose [rad], shape (n,).
            start: Angles of all nq joints at the start [rad], shape (nq,).

        Returns:
            Configurations [rad] for the first m poses, shape (m, nq), and the next pose, which has no solution. If all
            n poses have a solution, m is n, and None is returned instead of the next pose.
        """
        found: list[np.ndarray] = []
        q = start
        for point, targets in enumerate(tools.swapaxes(0, 1)):
            if self._robot.trunk is not None:
                q = q.copy()
                q[self._robot.columns[self._robot.trunk]] = trunk[point]
            q, missed = self._solve(q, targets, point)
            if missed:
                return np.array(found).reshape(-1, len(start)), missed
            found.append(q)
        return np.array(found), None

    def _solve(self, start: np.ndarray, targets: np.ndarray, point: int) -> tuple[np.ndarray, Missed | None]:
        self._configuration.update(start)
        for task, X_BT in zip(self._tasks, targets, strict=True):
            task.set_target(self._target(X_BT))
        errors = self._errors()
        for _ in range(STEPS):
            if max(errors) < REACHED:
                return self._configuration.q.copy(), None
            velocity = self._step()
            if velocity is None:
                break
            self._configuration.integrate_inplace(velocity / max(1.0, np.abs(velocity).max() / 0.3), 1.0)
            errors = self._errors()
        return start, self._missed(point, errors)

    def _step(self) -> np.ndarray | None:
        """Return the velocity of every joint that moves the tools towards their target poses.

        Return None if no velocity satisfies the limits.
        """
        try:
            return np.asarray(
                self._mink.solve_ik(
                    self._configuration,
                    self._tasks,
                    1.0,
                    "daqp",
                    damping=1e-9,
                    limits=self._limits,
                    constraints=self._frozen,
                )
            )
        except self._mink.NoSolutionFound:
            return None

    def _target(self, X_BT: np.ndarray) -> object:
        R_WT, p_WT = self.R_WB @ X_BT[:3, :3], self.R_WB @ X_BT[:3, 3] + self.p_WB
        return self._mink.SE3(np.concatenate([to_quaternion(R_WT), p_WT]))

    def _errors(self) -> list[float]:
        return [
            float(np.linalg.norm(task.compute_error(self._configuration) * np.append(np.ones(3), LENGTH * counted)))
            for task, counted in zip(self._tasks, self._counted, strict=True)
        ]

    def _missed(self, point: int, errors: list[float]) -> Missed:
        worst = int(np.argmax(errors))
        arm = self._robot.folding[worst]
        angles = self._configuration.q[[self._robot.columns[name] for name in arm.joints]]
        room = np.abs(angles[:, None] - self._robot.limits(arm)).min(axis=1)
        joint = arm.joints[int(room.argmin())] if room.min() < 1e-4 else None
        error = self._tasks[worst].compute_error(self._configuration)
        turn = error[3:] * self._counted[worst]
        return Missed(point, arm.name, float(np.linalg.norm(error[:3])), float(np.linalg.norm(turn)), joint)
