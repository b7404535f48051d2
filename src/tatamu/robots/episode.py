"""A plan as one episode of a LeRobotDataset, in the robot's own keys and units, for LeRobot's replay.

`observation.state` is the plan at each frame. `action` is the plan one frame later, because an action is the command
that leads to the next frame.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from tatamu.lerobot import LeRobotWriter, vector
from tatamu.robots.arm import Arm
from tatamu.robots.model import Robot, state_names
from tatamu.robots.plan import SHUT, RobotPlan
from tatamu.study.folder import ResultFolder

FPS = 30
"""Frames per second. This is LeRobot's usual rate."""
STATE, ACTION = "observation.state", "action"


def episode_writer(robot: Robot, folder: Path) -> LeRobotWriter:
    """Start the dataset of a robot.

    Raises:
        InputError: If the folder contains something, or a package is missing.
    """
    numbers = vector(state_names(robot))
    return LeRobotWriter(folder, FPS, {STATE: numbers, ACTION: numbers}, robot.lerobot_type or robot.name)


def add_plan(writer: LeRobotWriter, plan: RobotPlan) -> None:
    """Append a plan to the dataset, as one episode."""
    last = float(plan.motion.times[-1])
    times = np.arange(int(np.ceil(last * FPS)) + 1) / FPS
    values = {STATE: state(plan, times), ACTION: state(plan, np.minimum(times + 1 / FPS, last))}
    learned = plan.task.source
    if isinstance(learned, ResultFolder) and not learned.result_file.exists():
        writer.add_episode(values, "Fold the cloth.")
    else:
        task = learned.record.task
        writer.add_episode(values, f"Fold the {task.garment} ({task.fold}).")


def state(plan: RobotPlan, times: np.ndarray) -> np.ndarray:
    """Return the robot's planned state at n times [s]: k values for each time, shape (n, k).

    The values are in the order of `state_names`.
    """
    robot, motion = plan.task.robot, plan.motion
    columns: list[np.ndarray] = []
    for arm in robot.arms:
        angles = [np.interp(times, motion.times, motion.angles[:, robot.columns[name]]) for name in arm.joints]
        gripper, names = widths(plan, arm, times), arm.lerobot
        if names.open is not None and names.closed is not None:  # the gripper has own values, not widths in metres
            gripper = names.closed + (gripper - SHUT) / (arm.jaw.opening - SHUT) * (names.open - names.closed)
        columns += [*names.values(np.stack(angles, axis=1)).T, gripper]
    if robot.trunk is not None:
        columns.append(np.interp(times, motion.times, motion.angles[:, robot.columns[robot.trunk]]))
    return np.stack(columns, axis=1)


def widths(plan: RobotPlan, arm: Arm, times: np.ndarray) -> np.ndarray:
    """Return the planned distance between the fingertips [m] at each of n times [s], shape (n,)."""
    commands = [command for command in plan.gripper_commands if command.arm == arm.name]
    found = np.full(len(times), arm.jaw.opening)
    for before, command in itertools.pairwise(commands):
        done = np.clip((times - command.time) / max(command.duration, 1e-9), 0.0, 1.0)
        found += done * (command.width - before.width)
    return found
