"""Build the robot of a description from the models that the description names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.robots.clearance import Clearance
from tatamu.robots.description import (
    ArmDescription,
    Description,
    disturbances_in_description,
    model_of,
    read_description,
)
from tatamu.robots.extras import needed, quiet
from tatamu.robots.model import Arm, Robot, StartPose
from tatamu.robots.modelfile import ModelFile, give, limit_continuous
from tatamu.robots.pose import to_quaternion
from tatamu.robots.soundness import check_description

FASTEST = 20.0
"""Speed limit for joints without a limit in the robot's model [rad/s].

Most speeds that were typed in degrees instead of radians exceed this limit.
"""


def described(path: Path) -> Robot:
    """Load a robot from its description and the models that the description names.

    Raises:
        InputError: If a file cannot be read, a field is wrong, or the robot cannot be planned for.
    """
    with quiet():  # MuJoCo warns of options that differ between two models; no plan depends on these options
        return _described(path)


def _described(path: Path) -> Robot:
    description = read_description(path)
    disturbances_in_description(path, description)
    arms = {"larm": description.larm, "rarm": description.rarm}
    pair = description.model is None
    prefixes = {name: f"{name}_" if pair else "" for name in arms}
    models = {name: model_of(path, description, name) for name in description.models}
    files = {name: models[arm.model or description.model or ""] for name, arm in arms.items()}
    turning = {name: limit_continuous(files[name], arm.joints) for name, arm in arms.items()}
    spec = _pair(arms, files, prefixes) if pair else _whole(files["larm"])
    above: list[str] = []
    larm, rarm = (_arm(path, name, arm, prefixes[name], files[name], above) for name, arm in arms.items())
    robot = Robot(
        name=description.name,
        spec=spec,
        base=description.base,
        larm=larm,
        rarm=rarm,
        joints=(*larm.joints, *rarm.joints),
        trunk=None,
        trunk_speed=(1.0, 1.0),
        trunk_acceleration=1.0,
        poses=(StartPose("initial", larm.initial, rarm.initial),),
        table_heights=description.table_heights,
        front=description.front,
        standing=_standing(description, prefixes),
        lerobot_type=description.lerobot_type,
        notes=(*_notes(path, above), *_mended(path, arms, files, turning), *_outside(path, description, models)),
    )
    check_description(path, robot, prefixes)
    return replace(robot, notes=(*robot.notes, *_untested(path, robot)))


def _untested(path: Path, robot: Robot) -> list[str]:
    found = [" and ".join(names) for names in Clearance(robot).untested]
    if not found:
        return []
    return [f"{path}: taken to stand on each other, as they touch at the start, so not held apart: {', '.join(found)}"]


def _standing(description: Description, prefixes: dict[str, str]) -> dict[str, float]:
    found = dict(description.standing)
    for name, arm in (("larm", description.larm), ("rarm", description.rarm)):
        found |= {prefixes[name] + joint: value for joint, value in arm.standing.items()}
    return found


def _arm(path: Path, name: str, arm: ArmDescription, prefix: str, file: ModelFile, above: list[str]) -> Arm:
    speed, acceleration = _within_model(path, name, arm, file, above)
    return Arm(
        name=name,
        joints=tuple(prefix + joint for joint in arm.joints),
        link=prefix + arm.link,
        tool_in_wrist=arm.tool.matrix,
        initial=np.array(arm.initial),
        speed=speed,
        planned_speed=speed,
        planned_acceleration=acceleration,
        jaw=arm.jaw.prefixed(prefix),
        ros=arm.ros,
        lerobot=arm.lerobot,
    )


def _within_model(
    path: Path, name: str, arm: ArmDescription, file: ModelFile, above: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest speeds and the largest accelerations of the arm's k joints in plans, two arrays of shape (k,).

    A speed above the model's own limit is lowered to that limit, and the joint's name is appended to the list `above`.
    The joint's acceleration is lowered by the same factor, so the joint reaches its speed in the same time. Without
    this reduction, an acceleration that was typed in degrees instead of radians would stay 57 times too high.
    """
    limits = []
    for joint, speed in zip(arm.joints, arm.speed, strict=True):
        own = file.speeds.get(joint)
        if own is None and speed > FASTEST and joint not in arm.faster_than_model:
            raise InputError(
                f"{path}: {name}.speed: {joint} must be at most {FASTEST:g} rad/s, as the model states no limit, "
                f"given {speed:g}; write radians, or name the joint in faster_than_model"
            )
        lowered = own is not None and speed > own * (1 + 1e-6) and joint not in arm.faster_than_model
        limits.append(own if lowered and own is not None else speed)
        if lowered:
            above.append(f"{name} {joint} {speed:g} ({own:g})")
    kept = np.array(limits)
    return kept, np.array(arm.acceleration) * (kept / np.array(arm.speed))


def _notes(path: Path, above: list[str]) -> tuple[str, ...]:
    if not above:
        return ()
    return (
        f"{path}: speed: above the model's own limit [rad/s], which plans keep to, "
        f"with accelerations lowered likewise: {', '.join(above)}; to keep yours, name the joints in faster_than_model",
    )


def _mended(
    path: Path, arms: dict[str, ArmDescription], files: dict[str, ModelFile], turning: dict[str, list[str]]
) -> Iterator[str]:
    """Yield what plans do about joints and links whose model says something unusual."""
    soft = [
        f"{name} {joint} {files[name].soft[joint]}" for name, arm in arms.items() for joint in _soft(arm, files[name])
    ]
    if soft:
        yield f"{path}: soft limits are narrower than the hard limits, and plans keep to them [rad]: {', '.join(soft)}"
    free = [f"{name} {joint}" for name, joints in turning.items() for joint in joints]
    if free:
        yield f"{path}: continuous joints, which plans turn by at most one turn to either side: {', '.join(free)}"
    links = sorted({link for file in files.values() for link in file.mended})
    if links:
        yield (
            f"{path}: impossible masses or inertias, replaced because only a rehearsal needs them: {', '.join(links)}"
        )


def _soft(arm: ArmDescription, file: ModelFile) -> list[str]:
    return [joint for joint in (*arm.joints, *arm.jaw.fingers) if joint in file.soft]


def _outside(path: Path, description: Description, models: dict[str, ModelFile]) -> Iterator[str]:
    """Yield a note on files outside the folder of the description, because plans and results contain copies of them."""
    folder = os.path.abspath(path.parent)
    used = {os.path.abspath(file) for model in models.values() for file in model.files}
    found = sorted(file for file in used if os.path.commonpath([file, folder]) != folder)
    if found:
        yield f"{path}: files from outside its folder, which plans and results contain copies of: {', '.join(found)}"


def _whole(file: ModelFile) -> object:
    give(file.spec, file.contents)
    return file.spec


def _pair(arms: dict[str, ArmDescription], files: dict[str, ModelFile], prefixes: dict[str, str]) -> object:
    """Join two single arms in one model.

    The names of the left arm's parts get the prefix `larm_`. The names of the right arm's parts get the prefix `rarm_`.
    """
    spec = needed("mujoco").MjSpec()
    spec.compiler.degree = False
    contents: dict[str, bytes] = {}
    for name, arm in arms.items():
        X_BM = arm.mount.matrix
        frame = spec.worldbody.add_frame(pos=X_BM[:3, 3], quat=to_quaternion(X_BM[:3, :3]))
        spec.attach(files[name].spec.copy(), prefix=prefixes[name], frame=frame)
        contents |= files[name].contents
    give(spec, contents, tuple(prefixes.values()))
    return spec
