"""Requirements that a robot must satisfy for correct plans. They are checked when the robot is loaded.

- The names in the description must exist in the model.
- The joints must move independently.
- The arms must be able to move in every direction that a fold needs.
- `Chain`, with which plans are computed, and MuJoCo must have the same kinematics.

The last three checks use random configurations from the joints' whole ranges, with a fixed seed.
"""

from __future__ import annotations

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
    _check_names(path, robot)
    try:
        model = robot.model
    except ValueError as error:
        raise InputError(f"{path}: the model does not compile ({one_line(error)})") from None
    _check_numbers(path, model)
    _check_joints(path, model)
    for arm in robot.arms:
        _check_arm(path, robot, arm, prefixes[arm.name])
    _check_base(path, robot)
    _check_equalities(path, robot)
    _check_standing(path, robot)
    for arm in robot.arms:
        angles = _within(robot.limits(arm), np.random.default_rng(0))
        best = float(Chain.of(robot, arm).singularity(angles).max())
        if not best > MIN_RANK:
            directions = min(len(arm.joints), FULL_JOINTS)
            raise InputError(
                f"{path}: {arm.name}.joints: must move and turn the tool in {directions} directions, given "
                f"fewer (the minimum singular value of the Jacobian is {best:.1e}); add a joint with another "
                "axis"
            )
    for arm in robot.arms:
        if not Clearance(robot, ("to the table",), arm.name).pairs:
            raise InputError(
                f"{path}: {arm.name}: must have collision shapes in the model, because distances are measured "
                "between these shapes"
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
                    f"robot {robot.name}: {arm.name}: the tool must be at the same position in the plan and in "
                    f"MuJoCo, given {1e3 * error[:3, 3].max():.3g} mm between both; give another model"
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


def _check_names(path: Path, robot: Robot) -> None:
    """Refuse names in the description that the model does not have."""

    def check(field: str, kind: str, name: str) -> None:
        if getattr(robot.spec, kind)(name) is None:
            raise InputError(f"{path}: {field}: must name a {kind} of the model, given {name!r}")

    for arm in robot.arms:
        check(f"{arm.name}.link", "body", arm.link)
        for joint in arm.joints:
            check(f"{arm.name}.joints", "joint", joint)
    for joint in robot.rarm.joints:
        if joint in robot.larm.joints:
            raise InputError(f"{path}: rarm.joints: {joint} already belongs to larm")
    for joint in robot.standing:
        check("standing", "joint", joint)
        if joint in robot.joints:
            raise InputError(f"{path}: standing: must contain joints outside the arms only, given {joint}")
    for arm in robot.arms:
        for joint in arm.jaw.fingers:
            if robot.spec.joint(joint) is None or joint in robot.joints:
                raise InputError(
                    f"{path}: {arm.name}.jaw.fingers: must be joints of the model outside the arms, given {joint!r}"
                )
        for link in arm.jaw.links:
            check(f"{arm.name}.jaw.links", "body", link)
    if robot.base != "world":
        check("base", "body", robot.base)


def _check_numbers(path: Path, model: Any) -> None:
    """Refuse models with numbers that no robot has. MuJoCo accepts even infinite numbers."""
    limit = 1e4  # [m, rad, kg, kg m^2]
    bodies = ("body_pos", "body_quat", "body_mass", "body_inertia", "geom_pos", "geom_size")
    for name in (*bodies, "jnt_pos", "jnt_axis", "jnt_range", "qpos0"):
        values = getattr(model, name)
        if not (np.abs(values) <= limit).all():
            worst = values.flat[int(np.argmax(np.where(np.isfinite(values), np.abs(values), np.inf)))]
            raise InputError(f"{path}: model: {name} must be within {limit:g} (SI units), given {worst:.4g}")


def _check_joints(path: Path, model: Any) -> None:
    """Refuse joints without a single angle or position, such as ball joints."""
    kinds = needed("mujoco").mjtJoint
    words = {int(kinds.mjJNT_FREE): "free", int(kinds.mjJNT_BALL): "ball"}
    for number in range(model.njnt):
        word = words.get(int(model.jnt_type[number]))
        if word is not None:
            name, body = model.joint(number).name, model.body(model.jnt_bodyid[number]).name
            raise InputError(
                f"{path}: model: every joint must be a hinge or a slide, given the {word} joint {name} of "
                f"body {body!r}; fix the body to its parent, or remove it from the model"
            )


def _check_arm(path: Path, robot: Robot, arm: Arm, prefix: str) -> None:
    """Refuse joints that are not hinges with limits, or that do not lead to the wrist in the given order."""
    model, where = robot.model, f"{path}: {arm.name}.joints:"
    for joint, angle in zip(arm.joints, arm.initial, strict=True):
        if model.joint(joint).type[0] != needed("mujoco").mjtJoint.mjJNT_HINGE:
            raise InputError(f"{where} must be hinges, given the slide {joint.removeprefix(prefix)}")
        if not model.joint(joint).limited[0]:
            raise InputError(
                f"{where} must each have a range in the model, given {joint.removeprefix(prefix)} without a range"
            )
        low, high = model.joint(joint).range
        if not low <= angle <= high:
            raise InputError(
                f"{path}: {arm.name}.initial: {joint} must be from {low:.4g} to {high:.4g} rad, given {angle:.4g}"
            )
    for joint, positions in arm.jaw.fingers.items():
        low, high = model.joint(joint).range
        if model.joint(joint).limited[0] and not low - 1e-9 <= min(positions) <= max(positions) <= high + 1e-9:
            raise InputError(
                f"{path}: {arm.name}.jaw.fingers: {joint.removeprefix(prefix)} must be from {low:.4g} to {high:.4g}, "
                f"given {positions[0]:g} and {positions[1]:g}"
            )
    names = [name.removeprefix(prefix) for name in arm.joints]
    above = joints_above(model, model.body(arm.link).id)
    on_the_way = [str(model.joint(number).name).removeprefix(prefix) for number in above]
    for name in names:
        if name not in on_the_way:
            raise InputError(f"{where} must move {arm.link.removeprefix(prefix)}, given {name}, which does not")
    ordered = [name for name in on_the_way if name in names]
    if names != ordered:
        raise InputError(f"{where} must be in the order from the base to the hand: {', '.join(ordered)}")


def _check_base(path: Path, robot: Robot) -> None:
    """Refuse a base that an arm moves, or that is not upright."""
    for number in joints_above(robot.model, robot.model.body(robot.base).id):
        joint = robot.model.joint(number).name
        if joint in robot.joints:
            raise InputError(f"{path}: base: must not move, given {robot.base}, which {joint} moves")
    tilt = np.degrees(np.arccos(np.clip(robot.at_rest().body(robot.base).xmat[8], -1, 1)))
    if not tilt < 1e-3:
        raise InputError(f"{path}: base: z of {robot.base} must point up, given {tilt:.3g} degrees from the vertical")


def _check_standing(path: Path, robot: Robot) -> None:
    """Refuse positions of joints, such as those in `standing`, that are outside the joints' ranges."""
    model = robot.model
    for number in range(model.njnt):
        name, (low, high) = model.joint(number).name, model.jnt_range[number]
        value = robot.standing.get(name, robot.rest[model.jnt_qposadr[number]])
        if model.jnt_limited[number] and not low - 1e-9 <= value <= high + 1e-9:
            raise InputError(f"{path}: standing: {name} must be from {low:.4g} to {high:.4g}, given {value:.4g}")


def _check_equalities(path: Path, robot: Robot) -> None:
    """Refuse arms whose joints do not move independently: mimic joints, coupled joints, closed loops of links."""
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
        raise InputError(
            f"{path}: model: equality constraints must hold in all poses of the arms, given deviations of "
            f"up to {worst.max():.3g}: {', '.join(broken)}; remove these constraints, or the joints that "
            "violate them"
        )


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
