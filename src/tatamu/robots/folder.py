"""The folder of a plan, which is written as a whole or not at all. See docs/reference/robot-plan.md."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import unwritable, write_json, write_text
from tatamu.base.version import __version__
from tatamu.folding.fingers import FingerSize
from tatamu.folding.manipulation import VIA_EVERY
from tatamu.robots.arm import Arm
from tatamu.robots.exports import (
    gripper_csv,
    joint_csv,
    pattern_json,
    trajectory_json,
    write_goals,
    write_ros1,
    write_ros2,
)
from tatamu.robots.paths import Paths, tool_poses
from tatamu.robots.picture import reach_svg
from tatamu.robots.placement import Hold
from tatamu.robots.plan import RobotPlan
from tatamu.robots.planfile import FOLD, FoldPose, JawFile, PlanFile, StageTime, ToolViaPoints
from tatamu.robots.pose import pose
from tatamu.robots.stage import save_stage
from tatamu.study.folder import MANIPULATION, RESULT, ROLLOUT, SCENE, ResultFolder
from tatamu.study.result import Result


def check_out(out: Path) -> None:
    """Check, before any work is done, that a plan can be written to this path.

    Raises:
        InputError: If the path exists and is not the folder of a plan.
    """
    if out.resolve() == Path.cwd():
        raise InputError(
            f"{out}: must not be the current folder, because a plan replaces the whole folder; give another --out"
        )
    if out.exists() and not (out.is_dir() and (not any(out.iterdir()) or (out / "plan.json").is_file())):
        raise InputError(f"{out}: must be a new folder or the folder of a plan, but is neither; give another --out")


def save(plan: RobotPlan, out: Path) -> None:
    """Write the folder of a plan. If the folder contains an earlier plan, the earlier plan is replaced.

    Raises:
        InputError: If `out` cannot be written, or contains something other than a plan.
    """
    check_out(out)
    with replacing_folder(out) as folder:
        write_json(folder / "plan.json", plan_file(plan).model_dump())
        write_text(folder / "joint_trajectory.csv", joint_csv(plan))
        write_json(folder / "joint_trajectory.json", trajectory_json(plan))
        write_json(folder / "play_pattern.json", pattern_json(plan))
        write_text(folder / "gripper_commands.csv", gripper_csv(plan))
        write_goals(plan, folder / "goals")
        write_ros1(plan, folder / "joint_trajectory.bag")
        write_ros2(plan, folder / "joint_trajectory_ros2")
        write_text(folder / "reach.svg", reach_svg(plan))
        _keep_fold(plan.task.source, folder / FOLD)
        save_stage(plan.task.robot, plan.task.table, folder)


def _keep_fold(fold: Result | ResultFolder, folder: Path) -> None:
    """Write the files of the learned fold that a rehearsal reads, so that the plan's folder is self-contained."""
    if isinstance(fold, Result):
        fold.save(folder)
        return
    folder.mkdir()
    for name in (MANIPULATION, SCENE, ROLLOUT, RESULT):  # all files except the first can be missing
        if (fold.path / name).is_file():
            shutil.copyfile(fold.path / name, folder / name)


@contextmanager
def replacing_folder(out: Path) -> Iterator[Path]:
    """Yield an empty folder for a `with` block, which then takes the place of `out`.

    The earlier folder moves aside before the new one comes, so a kill leaves one of them whole.
    """
    try:
        out = out.resolve()  # a symbolic link remains a link
        out.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".tatamu-", dir=out.parent) as temporary:
            new, old = Path(temporary) / "new", Path(temporary) / "old"
            new.mkdir()
            yield new
            try:
                if out.exists():
                    out.rename(old)
                new.rename(out)
            except BaseException:
                if old.exists():
                    old.rename(out)
                raise
    except OSError as error:
        raise unwritable(out, error) from None


def plan_file(plan: RobotPlan) -> PlanFile:
    """Return the contents of plan.json."""
    task, motion = plan.task, plan.motion
    robot, placement = task.robot, task.placement
    return PlanFile(
        version=1,
        tatamu=__version__,
        robot=robot.name,
        base_frame=robot.base,
        task_in_base=FoldPose(xyz=(placement.x, placement.y, placement.z), yaw=placement.yaw),
        notes=list(robot.notes),
        initial_pose=robot.start,
        trunk_turning=placement.turning,
        tool_in_wrist={
            arm.name: (arm.tool_in_wrist @ pose(np.eye(3), -R_BT.T @ offset)).tolist()
            for arm, (R_BT, offset, _) in zip(robot.folding, task.grips, strict=True)
        },
        jaws={arm.name: _jaw(arm, hold) for arm, hold in zip(robot.folding, task.holds, strict=True)},
        wrist_frame={arm.name: arm.link for arm in robot.folding},
        joints=list(robot.joints),
        duration=float(motion.times[-1]),
        events=list(plan.events),
        gripper_commands=list(plan.gripper_commands),
        segments=list(plan.segments),
        speed_scale=motion.speed_scale,
        hover=task.hover,
        stages=[StageTime(name=part.name, start=part.start, duration=part.timed.duration) for part in motion.parts],
        checks=plan.checks,
        via_points=_via_points(plan),
    )


def _jaw(arm: Arm, hold: Hold) -> JawFile:
    sizes = {name: getattr(arm.jaw, name) for name in FingerSize.model_fields}
    return JawFile(
        tilt=hold.tilt,
        yaw=hold.yaw,
        **sizes,
        depth=arm.jaw.depth,
        height=arm.jaw.height(hold.tilt),
        fingertips_in_wrist=arm.tool_in_wrist.tolist(),
        fingers=arm.jaw.fingers,
    )


def _via_points(plan: RobotPlan) -> ToolViaPoints:
    """Return the positions of the simulated hands at the via-points, and the times at which the robot is there."""
    task = plan.task
    fold = plan.motion.part("fold")
    times = task.hands.times
    fine = np.linspace(0, fold.timed.duration, 20001)
    driven = fold.start + np.interp(times, fold.timed.parameter(fine), fine)
    q = np.array([fold.timed.angles(np.array([time - fold.start]))[0] for time in driven])
    offsets = np.array([offset for _, offset, _ in task.grips])
    tools = tool_poses(task.robot, Paths(task).chains, q)[:, :, :3, 3] - offsets[:, None]
    return ToolViaPoints(
        every_frames=VIA_EVERY,
        frames=[task.hands.frame(float(time)) for time in times],
        simulated_times=times.tolist(),
        times=driven.tolist(),
        **{arm.name: points for arm, points in zip(task.robot.folding, tools, strict=True)},
    )
