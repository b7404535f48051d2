"""Load robots by name or from a description, and build them from the models that the description names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import beside
from tatamu.robots.arm import Arm
from tatamu.robots.description import ArmDescription, Description, disturbances_of, model_of, read_description
from tatamu.robots.extras import needed, quiet
from tatamu.robots.model import Robot, StartPose
from tatamu.robots.modelfile import ModelFile, give, limit_continuous
from tatamu.robots.pairs import link_name, pairs_of
from tatamu.robots.pose import to_quaternion
from tatamu.robots.soundness import check_description, check_kinematics

DATA = Path(__file__).parent / "data"
"""Folder of the robots of this package: a description of each, and its model."""
KAWADA = ("hironx", "nextage")
NAMES = (*KAWADA, "fr3-pair", "panda-pair", "ur5e-pair", "xarm7-pair", "so101-pair", "aloha2", "openarm")
"""Names of the robots of this package."""
MAX_SPEED = 20.0
"""Speed limit for joints without a limit in the robot's model [rad/s].

Most speeds that were typed in degrees instead of radians exceed this limit.
"""


def load(name: str, wrist_offset: float | None = None, fingertip: float | None = None) -> Robot:
    """Load a robot by name or from a TOML file.

    Args:
        name: One of `NAMES`, or the path of a description (see docs/reference/robot-description.md).
        wrist_offset: Distance from joint J4 to joint J5 along x [m]; only for HIRONX and NEXTAGE Open.
        fingertip: Distance from the last joint to the fingertip [m]; only for HIRONX and NEXTAGE Open.

    Raises:
        InputError: If no robot has this name, or the description is wrong.
    """
    if name not in NAMES and not name.endswith(".toml"):
        raise InputError(
            f"robot: must be one of {', '.join(NAMES)}, or a .toml file that describes a robot, given {name!r}"
        )
    if name not in KAWADA and (wrist_offset is not None or fingertip is not None):
        raise InputError(
            "wrist offset, fingertip: must be left out, except for hironx and nextage; for another robot, write both "
            "lengths into the .toml file of the robot"
        )
    if name not in NAMES:
        return described(Path(name))
    with quiet():
        return _assembled(DATA / f"{name}.toml", wrist_offset, fingertip)[0]  # tests check the robots of the package


def described(path: Path) -> Robot:
    """Load a robot from its description and the models that the description names, and check it.

    Raises:
        InputError: If a file cannot be read, a field is wrong, or the robot cannot be planned for.
    """
    with quiet():  # MuJoCo warns of options that differ between two models; no plan depends on these options
        robot, prefixes = _assembled(path)
        check_description(path, robot, prefixes)
        check_kinematics(robot)
        stands = [tuple(link_name(robot.model, geom) for geom in pair[1:]) for pair in pairs_of(robot)[1]]
    near = ", ".join(dict.fromkeys(" and ".join(names) for names in stands))
    note = f"{path}: these links touch at the start, so their distance is not checked: {near}"
    return replace(robot, notes=(*robot.notes, note)) if near else robot


def _with_lengths(
    description: Description, spec: Any, wrist_offset: float | None, fingertip: float | None
) -> Description:
    """Change lengths of a model of HIRONX or NEXTAGE Open, and return the description with the tools at the fingertips.

    Raises:
        InputError: If a length is outside the range that is possible for this wrist or hand.
    """
    if wrist_offset is not None and not -0.2 <= wrist_offset <= 0.0:
        raise InputError(f"wrist offset: must be from -0.2 to 0 m, given {wrist_offset:g}")
    if fingertip is not None and not 0.05 <= fingertip <= 0.4:
        raise InputError(f"fingertip: must be from 0.05 to 0.4 m beyond the wrist, given {fingertip:g}")
    arms = {}
    for name, arm in description.arms.items():
        wrist = spec.body(arm.link)
        if wrist_offset is not None:
            wrist.pos = [wrist_offset, *wrist.pos[1:]]
        if fingertip is not None:
            for finger in arm.jaw.links:
                spec.body(finger).pos = [-fingertip, 0.0, 0.0]
            hand = spec.geom(f"{arm.link}_hand")  # the box between the wrist and the fingers
            start = -hand.pos[0] - hand.size[0]
            end = max(start + 1e-3, fingertip - arm.jaw.length)
            hand.pos, hand.size = [-(start + end) / 2, 0.0, 0.0], [(end - start) / 2, *hand.size[1:]]
            tool = arm.tool.model_copy(update={"xyz": (-fingertip, 0.0, 0.0)})
            arms[name] = arm.model_copy(update={"tool": tool})
    return description.model_copy(update=arms)


def _assembled(
    path: Path, wrist_offset: float | None = None, fingertip: float | None = None
) -> tuple[Robot, dict[str, str]]:
    """Return the robot of a description, before it is checked, and the prefix of each arm's names in its model."""
    description = read_description(path)
    disturbances = disturbances_of(path, description)
    models = {name: model_of(path, description, name) for name in description.models}
    read = [path, *(file for model in models.values() for file in model.files)]
    if isinstance(description.disturbances, str):
        read.append(beside(path, description.disturbances))
    pair = description.model is None
    if description.model is not None:
        description = _with_lengths(description, models[description.model].spec, wrist_offset, fingertip)
    arms = description.arms
    prefixes = {name: f"{name}_" if pair else "" for name in arms}
    files = {name: models[arm.model or description.model or ""] for name, arm in arms.items()}
    turning = [f"{name} {joint}" for name, arm in arms.items() for joint in limit_continuous(files[name], arm.joints)]
    spec = _pair(arms, files, prefixes) if pair else files["larm"].spec
    contents = {asset: content for file in files.values() for asset, content in file.contents.items()}
    give(spec, contents, tuple(prefixes.values()))
    above: list[str] = []
    larm, rarm = (_arm(path, name, arm, prefixes[name], files[name], above) for name, arm in arms.items())
    trunk = description.trunk
    standing = {prefixes[name] + joint: at for name, arm in arms.items() for joint, at in arm.standing.items()}
    robot = Robot(
        name=description.name,
        spec=spec,
        base=description.base,
        larm=larm,
        rarm=rarm,
        joints=tuple(description.joints) or (*larm.joints, *rarm.joints),
        trunk=trunk.joint if trunk else None,
        trunk_limits=(trunk.speed, trunk.acceleration) if trunk else (1.0, 1.0),
        poses=(
            StartPose(description.initial_pose, larm.initial, rarm.initial),
            *(StartPose(pose.name, np.array(pose.larm), np.array(pose.rarm)) for pose in description.poses),
        ),
        table_heights=description.table_heights,
        front=description.front,
        standing=description.standing | standing,
        lerobot_type=description.lerobot_type,
        notes=tuple(_notes(path, arms, files, above, turning)),
        files=tuple(dict.fromkeys(read)),
        disturbances=disturbances,
    )
    return robot, prefixes


def _arm(path: Path, name: str, arm: ArmDescription, prefix: str, file: ModelFile, above: list[str]) -> Arm:
    """Return an arm whose speeds are within the model, and add to `above` the joints whose speed was lowered."""
    limits = []
    for joint, speed in zip(arm.joints, arm.speed, strict=True):
        own = file.limits.speeds.get(joint)
        if joint not in arm.faster_than_model and own is None and speed > MAX_SPEED:
            raise InputError(
                f"{path}: {name}.speed: {joint} must be at most {MAX_SPEED:g} rad/s if the model states no limit, "
                f"given {speed:g}; convert degrees to radians, or name the joint in faster_than_model"
            )
        if joint not in arm.faster_than_model and own is not None and speed > own * (1 + 1e-6):
            above.append(f"{name} {joint} {speed:g} ({own:g})")
            speed = own
        limits.append(speed)
    return Arm(
        name=name,
        joints=tuple(prefix + joint for joint in arm.joints),
        link=prefix + arm.link,
        tool_in_wrist=arm.tool.matrix,
        initial=np.array(arm.initial),
        planned_speed=np.array(limits),
        planned_acceleration=np.array(arm.acceleration) * (np.array(limits) / np.array(arm.speed)),
        jaw=arm.jaw.prefixed(prefix),
        ros=arm.ros,
        lerobot=arm.lerobot,
    )


def _notes(
    path: Path,
    arms: dict[str, ArmDescription],
    files: dict[str, ModelFile],
    above: list[str],
    turning: list[str],
) -> Iterator[str]:
    """Yield what plans do about joints and links whose model says something unusual, and about distant files."""
    soft = [
        f"{name} {joint} {files[name].limits.soft[joint]}"
        for name, arm in arms.items()
        for joint in (*arm.joints, *arm.jaw.fingers)
        if joint in files[name].limits.soft
    ]
    mended = sorted({link for file in files.values() for link in file.mended})
    folder = os.path.abspath(path.parent)
    used = sorted({os.path.abspath(source) for file in files.values() for source in file.files})
    outside = [source for source in used if os.path.commonpath([source, folder]) != folder]
    lowered = "plans use the lower speed limits of the model [rad/s], and lower accelerations by the same factor"
    for said, names, advice in (
        (lowered, above, "; to use your speed, name the joints in faster_than_model"),
        ("plans keep to the soft limits, which are narrower than the hard limits [rad]", soft, ""),
        ("plans turn these continuous joints by at most one turn to either side", turning, ""),
        ("impossible masses or inertias of these links are replaced for rehearsals", mended, ""),
        ("plans and results contain copies of these files from outside the folder", outside, ""),
    ):
        if names:
            yield f"{path}: {said}: {', '.join(names)}{advice}"


def _pair(arms: dict[str, ArmDescription], files: dict[str, ModelFile], prefixes: dict[str, str]) -> Any:
    """Join two single arms in one model."""
    spec = needed("mujoco").MjSpec()
    spec.compiler.degree = False
    for name, arm in arms.items():
        X_BM = arm.mount.matrix
        frame = spec.worldbody.add_frame(pos=X_BM[:3, 3], quat=to_quaternion(X_BM[:3, :3]))
        spec.attach(files[name].spec.copy(), prefix=prefixes[name], frame=frame)
    return spec
