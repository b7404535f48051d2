"""The distance of the robot's palms and forearms from the simulated cloth of the learned fold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tatamu.robots.arm import Arm
from tatamu.robots.clearance import FAR, Distance
from tatamu.robots.extras import needed
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.motion import Motion
from tatamu.robots.pairs import CLOTH, DISTANCES, ON_TABLE, hand_shapes, link_name, pairs_of
from tatamu.robots.paths import PlacedFold
from tatamu.robots.placement import Grip, Hold
from tatamu.robots.pose import frame_pose, into, inverse, out_of, pose
from tatamu.simulation.rollout import Rollout

AT_THE_JAW = 0.04
"""Radius around a tool [m]. Cloth within this radius counts as held or lifted by the fingers."""
EVERY = 20
"""Number of samples of the robot's motion from one computation of the distance to the next."""


def clear_holds(robot: Robot, arm: Arm, hands: HandMotion, holds: Sequence[Hold], cloth: Rollout | None) -> np.ndarray:
    """Return for each orientation of a hand whether the hand stays out of the cloth, shape (holds,).

    Only the hand behind the fingers is tested, because its path in the frame of the fold does not depend on the
    placement. It is tested when it grasps, during the fold and after the release.
    """
    if cloth is None:
        return np.ones(len(holds), dtype=bool)
    frames = cloth.times[(cloth.times >= hands.times[0]) & (cloth.times <= hands.times[-1])][::3]  # every third
    times = np.concatenate([hands.times[:1], frames, hands.times[-1:]])
    rows = np.searchsorted(cloth.times, times[:-1]).clip(max=len(cloth.times) - 1)
    points = cloth.positions[[0, *rows[1:], -1]]
    number = robot.folding.index(arm)
    paths = hands.at(times)
    grip = Grip.of(arm.jaw, paths[number])
    held = (np.linalg.norm(points[None] - paths[:, :, None], axis=3) < AT_THE_JAW).any(axis=0)
    boxes = _boxes_behind_fingers(robot, arm)
    clear = []
    for hold in holds:
        R_FT, offset, _ = grip.tool(0.0, hold)
        in_tool = (points - (paths[number] + offset)[:, None]) @ R_FT
        in_tool = np.where(held[..., None], FAR, in_tool)
        least = min((float(_outside(into(X_TG, in_tool), box).min()) for X_TG, box in boxes), default=FAR)
        clear.append(least > DISTANCES[CLOTH].searched)
    return np.array(clear)


def _boxes_behind_fingers(robot: Robot, arm: Arm) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the boxes of the shapes that move with the tool and are no fingers."""
    data, model = robot.at_rest(), robot.model
    X_TW = inverse(frame_pose(data.site(arm.site)))
    return [
        (
            X_TW @ pose(data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]),
            model.geom_aabb[geom].reshape(2, 3),
        )
        for geom in hand_shapes(robot, arm)
        if link_name(model, geom) not in robot.fingers
    ]


def _outside(points: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return the distance of points [m], shape (.., 3), from a box; negative inside."""
    outside = np.abs(points - box[0]) - box[1]
    return np.asarray(np.linalg.norm(np.maximum(outside, 0.0), axis=-1) + np.minimum(outside.max(axis=-1), 0.0))


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
    geoms = [pair.first for pair in pairs_of(task.robot)[0] if pair.kind == ON_TABLE]
    best = Distance(FAR, 0, ("", ""))
    during = (motion.times >= motion.part("lower").start) & (motion.times <= motion.part("raise").end)
    for row in np.flatnonzero(during)[::EVERY]:
        points = out_of(task.placement.matrix, cloth.positions[_frame(motion, cloth, row)])
        free = (np.linalg.norm(points - tools[:, row, None, :3, 3], axis=2) > AT_THE_JAW).all(axis=0)
        points = points[free] @ R_WB.T + p_WB
        data.qpos[:] = motion.angles[row]
        mujoco.mj_kinematics(model, data)
        for geom in geoms if len(points) else ():
            local = (points - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
            near = _outside(local, model.geom_aabb[geom].reshape(2, 3))
            if near.min() < best.value:
                best = Distance(float(near.min()), int(row), (link_name(model, geom), "cloth"))
    return best


def _frame(motion: Motion, cloth: Rollout, row: int) -> int:
    """Return the index of the cloth's simulated frame that belongs to a sample of the robot's motion."""
    fold, time = motion.part("fold"), motion.times[row]
    if time < fold.start:
        return 0
    if time >= motion.part("open").start:
        return len(cloth.times) - 1
    simulated = float(motion.simulated(np.array([row]))[0])
    return int(np.clip(np.searchsorted(cloth.times, simulated), 0, len(cloth.times) - 1))
