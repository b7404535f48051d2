"""The distance of the robot's palms and forearms from the simulated cloth of the learned fold."""

from __future__ import annotations

import numpy as np

from tatamu.robots.clearance import Distance
from tatamu.robots.extras import needed
from tatamu.robots.motion import Motion
from tatamu.robots.pairs import FINGERS, ON_TABLE, link_name, pairs_of
from tatamu.robots.paths import PlacedFold
from tatamu.simulation.rollout import Rollout
from tatamu.study.folder import ResultFolder

AT_THE_JAW = 0.04
"""Radius around a tool [m]. Cloth within this radius counts as held or lifted by the fingers."""
FAR = 0.15
"""Largest distance between robot and cloth that is computed [m]. Larger distances count as this value."""
EVERY = 20
"""Number of samples of the robot's motion from one computation of the distance to the next."""


def simulated_cloth(task: PlacedFold) -> Rollout | None:
    """Return the simulated motion of the cloth in the learned fold; None if the fold's folder has no such motion."""
    folder = ResultFolder(task.source)
    return folder.rollout if folder.rollout_file.is_file() else None


def nearest_cloth(task: PlacedFold, motion: Motion, tools: np.ndarray, cloth: Rollout) -> Distance:
    """Return the smallest distance between the cloth and the robot's shapes, except its fingers.

    The motion is checked from the time when the hands are lowered until they have left the cloth. Shapes are
    represented by boxes that contain them, and the cloth by its vertices. The cloth is at rest before the fold starts
    and after the fold ends.

    Args:
        task: The learned fold, placed in front of the robot.
        motion: The robot's motion.
        tools: Pose of each arm's tool in the base, at the samples of the motion, shape (arms, n, 4, 4).
        cloth: The simulated motion of the cloth, in the frame of the fold.
    """
    mujoco, model = needed("mujoco"), task.robot.model
    data = task.robot.at_rest()
    base = data.body(task.robot.base)
    R_WB, p_WB = base.xmat.reshape(3, 3).copy(), base.xpos.copy()
    rows = pairs_of(task.robot).rows
    geoms = rows[ON_TABLE][:, 0] if ON_TABLE in rows else rows[FINGERS][:0, 0]
    X_BF = task.placement.matrix
    best = Distance(FAR, 0, ("", ""))
    for row in _rows(motion):
        points = cloth.positions[_frame(task, motion, cloth, row)] @ X_BF[:3, :3].T + X_BF[:3, 3]
        free = (np.linalg.norm(points - tools[:, row, None, :3, 3], axis=2) > AT_THE_JAW).all(axis=0)
        points = points[free] @ R_WB.T + p_WB
        data.qpos[:] = motion.angles[row]
        mujoco.mj_kinematics(model, data)
        for geom in geoms if len(points) else ():
            local = (points - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
            outside = np.abs(local - model.geom_aabb[geom, :3]) - model.geom_aabb[geom, 3:]
            near = np.linalg.norm(np.maximum(outside, 0.0), axis=1) + np.minimum(outside.max(axis=1), 0.0)
            if near.min() < best.value:
                best = Distance(float(near.min()), int(row), (link_name(model, int(geom)), "cloth"))
    return best


def _rows(motion: Motion) -> np.ndarray:
    last = motion.part("raise")
    inside = (motion.times >= motion.part("lower").start) & (motion.times <= last.start + last.timed.duration)
    return np.flatnonzero(inside)[::EVERY]


def _frame(task: PlacedFold, motion: Motion, cloth: Rollout, row: int) -> int:
    """Return the index of the cloth's simulated frame that belongs to a sample of the robot's motion."""
    fold, time = motion.part("fold"), motion.times[row]
    if time < fold.start:
        return 0
    if time >= motion.part("open").start:
        return len(cloth.times) - 1
    simulated = float(motion.simulated(np.array([row]))[0])
    return int(np.clip(np.searchsorted(cloth.times, simulated), 0, len(cloth.times) - 1))
