"""Requirements that a robot must satisfy for correct plans. They are checked when the robot is loaded.

- The names in the description must exist in the model.
- The joints must move independently.
- The arms must be able to move in every direction that a fold needs.
- `Chain`, with which plans are computed, and MuJoCo must have the same kinematics.

The last three checks use random configurations from the joints' whole ranges, with a fixed seed.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.robots.arm import Arm
from tatamu.robots.chain import FULL_JOINTS, Chain
from tatamu.robots.clearance import Clearance
from tatamu.robots.extras import needed, one_line
from tatamu.robots.model import Robot
from tatamu.robots.pairs import joints_above
from tatamu.robots.pose import frame_pose, inverse

DRAWS = 32
MIN_RANK = 1e-4
"""Limit for the smallest singular value of an arm's Jacobian, as computed by `Chain.singularity`.

The value must exceed this limit in at least one of the random configurations. Otherwise the arm cannot be used.
"""


def check_description(path: Path, robot: Robot, prefixes: dict[str, str]) -> None:
    """Refuse a description that does not fit its model.

    Args:
        path: The description, for messages.
        robot: The robot that was made from the description.
        prefixes: Prefix for each arm, which the robot's model adds to the names in the arm's own model.

    Raises:
        InputError: If a name is unknown, a value is out of range, or the arms cannot be planned for.
    """
    for wrong in _wrong(robot, prefixes):
        raise InputError(f"{path}: {wrong}")


def _wrong(robot: Robot, prefixes: dict[str, str]) -> Iterator[str]:
    """Yield what is wrong. After the first yield, the rest makes no sense."""
    yield from _wrong_names(robot)
    try:
        model = robot.model
    except ValueError as error:
        yield f"the model does not compile ({one_line(error)})"
    yield from _wrong_numbers(model)
    yield from _wrong_joints(model)
    for arm in robot.arms:
        yield from _wrong_arm(robot, arm, prefixes[arm.name])
    yield from _wrong_base(robot)
    yield from _broken_equalities(robot)
    yield from _wrong_standing(robot)
    for arm in robot.arms:
        angles = _within(robot.limits(arm), np.random.default_rng(0))
        best = float(Chain.of(robot, arm).singularity(angles).max())
        if not best > MIN_RANK:
            directions = min(len(arm.joints), FULL_JOINTS)
            yield (
                f"{arm.name}.joints: must move and turn the tool in {directions} directions, given fewer (the minimum "
                f"singular value of the Jacobian is {best:.1e}); add a joint with another axis"
            )
    for arm in robot.arms:
        if not Clearance(robot, ("to the table",), arm.name).pairs:
            yield (
                f"{arm.name}: must have collision shapes in the model, because distances are measured between these "
                "shapes"
            )


def check_kinematics(robot: Robot) -> None:
    """Compare the chains that plans use with MuJoCo's kinematics, which rehearsals use.

    Raises:
        InputError: If a chain and MuJoCo compute different positions of a tool; the message has the distance.
    """
    mujoco = needed("mujoco")
    data = robot.at_rest()
    X_BW = inverse(frame_pose(data.body(robot.base)))
    for configuration in _draws(robot):
        data.qpos[:] = configuration
        mujoco.mj_kinematics(robot.model, data)
        trunk = np.array(0.0 if robot.trunk is None else configuration[robot.columns[robot.trunk]])
        for arm in robot.arms:
            chain = Chain.of(robot, arm)
            angles = configuration[robot.arm_columns(arm)]
            X_BT = chain.trunk_pose(trunk) @ chain.tool(angles[None])[0][0]
            error = np.abs(X_BT - X_BW @ frame_pose(data.site(arm.site)))
            if not error.max() <= 1e-6:  # [m, and entries of the rotation]
                raise InputError(
                    f"robot {robot.name}: {arm.name}: the tool must be at the same position in the plan and in MuJoCo, "
                    f"but the positions are {1e3 * error[:3, 3].max():.3g} mm apart; give another model"
                )


def _draws(robot: Robot) -> np.ndarray:
    """Return random configurations of the arms and of the trunk, from their whole ranges, shape (DRAWS, nq)."""
    random = np.random.default_rng(0)
    angles = [_within(robot.limits(arm), random) for arm in robot.arms]
    trunk = None if robot.trunk is None else _within(robot.model.joint(robot.trunk).range[None], random)[:, 0]
    return robot.configuration(angles, trunk)


def _within(limits: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return random values of k joints, evenly distributed between the joints' limits, shape (DRAWS, k)."""
    low, high = limits.T
    return low + random.random((DRAWS, len(limits))) * (high - low)


def _wrong_names(robot: Robot) -> Iterator[str]:
    """Yield names in the description that the model does not have, and joints with two purposes."""

    def unknown(field: str, kind: str, *names: str) -> Iterator[str]:
        lacking = (name for name in names if getattr(robot.spec, kind)(name) is None)
        return (f"{field}: must name a {kind} of the model, given {name!r}" for name in lacking)

    for arm in robot.arms:
        yield from unknown(f"{arm.name}.link", "body", arm.link)
        yield from unknown(f"{arm.name}.joints", "joint", *arm.joints)
    for joint in robot.rarm.joints:
        if joint in robot.larm.joints:
            yield f"rarm.joints: {joint} already belongs to larm"
    for joint in robot.standing:
        yield from unknown("standing", "joint", joint)
        if joint in robot.joints:
            yield f"standing: must contain joints outside the arms only, given {joint}"
    for arm in robot.arms:
        for joint in arm.jaw.fingers:
            if robot.spec.joint(joint) is None or joint in robot.joints:
                yield f"{arm.name}.jaw.fingers: must be joints of the model outside the arms, given {joint!r}"
        yield from unknown(f"{arm.name}.jaw.links", "body", *arm.jaw.links)
    if robot.base != "world":
        yield from unknown("base", "body", robot.base)


def _wrong_numbers(model: Any) -> Iterator[str]:
    """Yield numbers that no robot has. MuJoCo accepts even infinite numbers."""
    limit = 1e4  # [m, rad, kg, kg m^2]
    bodies = ("body_pos", "body_quat", "body_mass", "body_inertia", "geom_pos", "geom_size")
    for name in (*bodies, "jnt_pos", "jnt_axis", "jnt_range", "qpos0"):
        values = getattr(model, name)
        if not (np.abs(values) <= limit).all():
            worst = values.flat[int(np.argmax(np.where(np.isfinite(values), np.abs(values), np.inf)))]
            yield f"model: {name} must be within {limit:g} (SI units), given {worst:.4g}"


def _wrong_joints(model: Any) -> Iterator[str]:
    """Yield joints without a single angle or position, such as ball joints."""
    kinds = needed("mujoco").mjtJoint
    words = {int(kinds.mjJNT_FREE): "free", int(kinds.mjJNT_BALL): "ball"}
    for joint in map(model.joint, range(model.njnt)):
        word = words.get(int(joint.type[0]))
        if word is not None:
            yield (
                f"model: every joint must be a hinge or a slide, given the {word} joint {joint.name} of body "
                f"{model.body(joint.bodyid[0]).name!r}; fix the body to its parent, or remove it from the model"
            )


def _wrong_arm(robot: Robot, arm: Arm, prefix: str) -> Iterator[str]:
    """Yield joints that are not hinges with limits, or that do not lead to the wrist in the given order."""
    model, hinge = robot.model, needed("mujoco").mjtJoint.mjJNT_HINGE
    where = f"{arm.name}.joints:"
    own = [name.removeprefix(prefix) for name in arm.joints]
    for name, angle, joint in zip(own, arm.initial, map(model.joint, arm.joints), strict=True):
        low, high = joint.range
        if joint.type[0] != hinge:
            yield f"{where} must be hinges, given the slide {name}"
        if not joint.limited[0]:
            yield f"{where} must each have a range in the model, given {name} without a range"
        if not low <= angle <= high:
            yield f"{arm.name}.initial: {joint.name} must be from {low:.4g} to {high:.4g} rad, given {angle:.4g}"
    for name, positions in arm.jaw.fingers.items():
        low, high = model.joint(name).range
        if model.joint(name).limited[0] and not low - 1e-9 <= min(positions) <= max(positions) <= high + 1e-9:
            given = f"given {positions[0]:g} and {positions[1]:g}"
            yield f"{arm.name}.jaw.fingers: {name.removeprefix(prefix)} must be from {low:.4g} to {high:.4g}, {given}"
    above = joints_above(model, model.body(arm.link).id)
    on_the_way = [str(model.joint(number).name).removeprefix(prefix) for number in above]
    for name in own:
        if name not in on_the_way:
            yield f"{where} must move {arm.link.removeprefix(prefix)}, given {name}, which does not"
    ordered = [name for name in on_the_way if name in own]
    if own != ordered:
        yield f"{where} must be in the order from the base to the hand: {', '.join(ordered)}"


def _wrong_base(robot: Robot) -> Iterator[str]:
    """Yield whether the base is moved by an arm, or is not upright."""
    for number in joints_above(robot.model, robot.model.body(robot.base).id):
        joint = robot.model.joint(number).name
        if joint in robot.joints:
            yield f"base: must not move, given {robot.base}, which {joint} moves"
    tilt = np.degrees(np.arccos(np.clip(robot.at_rest().body(robot.base).xmat[8], -1, 1)))
    if not tilt < 1e-3:
        yield f"base: z of {robot.base} must point up, given {tilt:.3g} degrees from the vertical"


def _broken_equalities(robot: Robot) -> Iterator[str]:
    """Yield whether joints of the arms do not move independently: mimic or coupled joints, closed loops of links."""
    mujoco, model = needed("mujoco"), robot.model
    data = mujoco.MjData(model)
    worst = np.zeros(model.neq)
    for configuration in (robot.initial, *_draws(robot)):
        data.qpos[:] = configuration
        mujoco.mj_fwdPosition(model, data)
        rows = np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        np.maximum.at(worst, data.efc_id[rows], np.abs(data.efc_pos[rows]))
    broken = [_equality(model, int(number)) for number in np.flatnonzero(worst > 1e-3)]  # [m, rad]
    if broken:
        yield (
            f"model: equality constraints must hold in all poses of the arms, given deviations of up to "
            f"{worst.max():.3g}: {', '.join(broken)}; remove these constraints, or the joints that violate them"
        )


def _wrong_standing(robot: Robot) -> Iterator[str]:
    """Yield positions of joints, such as those in `standing`, that are outside the joints' ranges."""
    model = robot.model
    for joint in map(model.joint, range(model.njnt)):
        low, high = joint.range
        value = robot.standing.get(joint.name, robot.rest[joint.qposadr[0]])
        if joint.limited[0] and not low - 1e-9 <= value <= high + 1e-9:
            yield f"standing: {joint.name} must be from {low:.4g} to {high:.4g}, given {value:.4g}"


def _equality(model: Any, number: int) -> str:
    """Return a text that names an equality constraint of the model."""
    kinds, body = needed("mujoco").mjtEq, int(needed("mujoco").mjtObj.mjOBJ_BODY)
    kind, first, second = int(model.eq_type[number]), int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
    if kind == int(kinds.mjEQ_JOINT):
        leader = f"follows {model.joint(second).name}" if second >= 0 else "stands still"
        return f"joint {model.joint(first).name} {leader}"
    if kind in (int(kinds.mjEQ_CONNECT), int(kinds.mjEQ_WELD)) and int(model.eq_objtype[number]) == body:
        return f"bodies {model.body(first).name} and {model.body(second).name} are joined"
    return f"equality {model.eq(number).name or number} holds"
