"""Floors, walls and whatever else stands in a model: an arm that would touch it is refused."""

from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.robots import Robot, RobotPlan, load, plan_fold
from tatamu.robots.clearance import FAR, Clearance
from tatamu.robots.model import TABLE
from tatamu.robots.pairs import ON_TABLE, link_name, pairs_of
from tatamu.robots.stage import touches
from tests.robots.arms import mjcf, pair, pair_of
from tests.robots.folds import folder

PLACE = (0.36, -0.16, 0.0)
"""Where the pair folds well on its own."""
ELEVATION = '<asset><hfield name="hill" nrow="2" ncol="2" size="2 2 0.24 0.1" elevation="0 0 1 1"/></asset>'
SLAB = '<asset><mesh name="slab" vertex="-2 -2 0 2 -2 0 -2 2 0 2 2 0 -2 -2 .25 2 -2 .25 -2 2 .25 2 2 .25"/></asset>'
PLANE = '<geom name="{name}" type="plane" size="0 0 1" pos="{pos}" zaxis="{axis}"/>'
FLOOR = PLANE.format(name="floor", pos="0 0 0.25", axis="0 0 1")


def robot_in(path: Path, world: str, more: str = "") -> Robot:
    """The pair of arms, the left one's model with more in it; its frame is 0.25 m to the left of the pair's."""
    (path / "left.xml").write_text(mjcf(world=world, more=more))
    (path / "right.xml").write_text(mjcf())
    return load(str(pair_of(path, "left.xml", "right.xml")))


def planned_in(path: Path, world: str, more: str = "") -> RobotPlan:
    return plan_fold(folder(path / "fold", span=0.24, width=0.18), robot_in(path, world, more), place=PLACE)


@pytest.mark.parametrize(
    ("world", "more"),
    [
        (FLOOR, ""),
        ('<geom type="plane" size="0.1 0.1 1" pos="0 0 0.25"/>', ""),
        ('<geom type="hfield" hfield="hill"/>', ELEVATION),
        ('<geom type="mesh" mesh="slab"/>', SLAB),
        ('<geom type="box" size="2 2 0.125" pos="0 0 0.125"/>', ""),
        (PLANE.format(name="wall", pos="0.4 0 0", axis="-1 0 0"), ""),
    ],
    ids=["floor", "small plane", "height field", "mesh", "box", "wall"],
)
def test_a_robot_that_would_go_through_something_is_refused(tmp_path: Path, world: str, more: str) -> None:
    with pytest.raises(InputError, match=r"distance to obstacles is|would touch something"):
        planned_in(tmp_path, world, more)


@pytest.mark.parametrize(
    "world",
    [FLOOR.replace("0.25", "0"), '<geom name="desk" type="box" size="0.6 0.6 0.02" pos="0.5 0 -0.02"/>'],
    ids=["floor", "table"],
)
def test_a_floor_or_a_table_of_the_model_as_high_as_the_table_is_the_table(tmp_path: Path, world: str) -> None:
    plan = planned_in(tmp_path, world)
    assert 0.002 <= plan.checks["distance_to_the_table"].value < 0.1
    assert least_of_all(plan) >= 0.002


def least_of_all(plan: RobotPlan) -> float:
    """Least distance at any sample from a moving link to what is neither itself nor next to it, by brute force."""
    model = plan.task.robot.model
    data = mujoco.MjData(model)
    solid = [geom for geom in range(model.ngeom) if model.geom_contype[geom]]
    near = {frozenset(pair) for pair in neighbours(plan.task.robot)}
    pairs = [
        (a, b)
        for a in solid
        for b in solid
        if a < b and frozenset((a, b)) not in near and model.geom_bodyid[a] != model.geom_bodyid[b]
    ]
    found = []
    for q in plan.motion.angles[::8]:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        found.append(min(mujoco.mj_geomDistance(model, data, a, b, 1.0, None) for a, b in pairs))
    return min(found)


def neighbours(robot: Robot) -> list[tuple[int, int]]:
    """Shapes of links with one or two joints between them."""
    found = []
    for arm in robot.arms:
        links = [int(robot.model.joint(name).bodyid[0]) for name in arm.joints]
        geoms = [int(robot.model.body_geomadr[link]) for link in links]
        found += [*pairwise(geoms), *zip(geoms, geoms[2:], strict=False)]
    return found


def test_the_least_distance_is_that_of_all_pairs_without_a_broad_phase(tmp_path: Path) -> None:
    world = FLOOR + PLANE.format(name="wall", pos="0.9 0 0", axis="-1 0 0.2") + '<geom type="hfield" hfield="hill"/>'
    robot = robot_in(tmp_path, world, ELEVATION)
    clearance = Clearance(robot)
    clearance.set_table(0.0)
    model = robot.model
    data = mujoco.MjData(model)
    kinds = {name for name, _, _ in clearance.pairs}
    assert kinds == {"between arms", "within an arm", "to obstacles", "to the table"}
    for q in np.random.default_rng(1).uniform(-2, 2, (20, model.nq)):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        data.geom(TABLE).xpos[2] = data.body(robot.base).xpos[2] - model.geom(TABLE).size[2]
        least = dict.fromkeys(kinds, FAR)
        for kind, a, b in clearance.pairs:
            distance = mujoco.mj_geomDistance(model, data, model.geom(a).id, model.geom(b).id, FAR, None)
            least[kind] = min(least[kind], distance)
        found = clearance.least(q[None])
        assert {kind: apart(found[kind].value) for kind in kinds} == pytest.approx(
            {kind: apart(value) for kind, value in least.items()}, abs=1e-9
        )


def apart(distance: float) -> float:
    """A distance, or -1: how deep a shape lies in a height field depends on the cut-off."""
    return distance if distance > 0 else -1.0


def test_every_link_of_an_arm_is_held_against_a_wall(tmp_path: Path) -> None:
    robot = robot_in(tmp_path, PLANE.format(name="wall", pos="0.9 0 0", axis="-1 0 0"))
    against = {link for kind, link, _ in Clearance(robot).pairs if kind == "to obstacles"}
    assert len(against) == 12  # all shapes of both arms


def test_each_clearance_has_a_table_of_its_own() -> None:
    robot = load("panda-pair")
    q = robot.initial[None]
    high, low = Clearance(robot, (ON_TABLE,), table=0.0), Clearance(robot, (ON_TABLE,), table=-0.1)
    height = min(high.lowest(robot.initial), low.lowest(robot.initial))
    high.set_table(height - 0.05)
    low.set_table(height - 0.1)
    assert high.least(q)[ON_TABLE].value == pytest.approx(0.05, abs=1e-6)
    assert low.least(q)[ON_TABLE].value == pytest.approx(0.1, abs=1e-6)


def test_what_an_arm_stands_on_is_not_held_against_it_and_is_said(tmp_path: Path) -> None:
    plinth = '<geom name="plinth" type="box" size="0.1 0.1 0.08" pos="0 0 0.08"/>'  # the first link begins at 0.155 m
    robot = robot_in(tmp_path, plinth)
    (stands,) = pairs_of(robot)[1]
    assert [link_name(robot.model, geom) for geom in stands[1:]] == ["larm_pan_link", "larm_plinth"]
    assert any("larm_pan_link and larm_plinth" in note for note in robot.notes)
    held = {(first, second) for kind, first, second in Clearance(robot).pairs if kind == "to obstacles"}
    assert len(held) == 11 and all("larm_pan_link" not in first for first, _ in held)


def test_the_second_opinion_finds_what_a_wrong_broad_phase_leaves_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Clearance, "_bounds", lambda self: np.full(len(self._first), np.inf))
    with pytest.raises(InputError, match=r"obstacles is -0.19\d* m, the limit 0.005 m, rarm_turn_link and larm_floor"):
        planned_in(tmp_path, FLOOR)


def test_contacts_are_asked_of_every_sample(tmp_path: Path) -> None:
    robot = robot_in(tmp_path, PLANE.format(name="wall", pos="0.8 0 0", axis="-1 0 0"))
    still = np.tile(robot.initial, (9, 1))
    assert touches(robot, 0.0, still) == {}
    still[5, [robot.columns[f"larm_{name}"] for name in ("lift", "elbow", "bend")]] = [1.5, 0.0, 0.0]  # 0.83 m long
    found = touches(robot, 0.0, still)
    assert found["to obstacles"].row == 5 and found["to obstacles"].pair[1] == "larm_wall"


def test_the_foot_of_the_other_arm_is_an_obstacle(tmp_path: Path) -> None:
    path = pair(tmp_path)
    text = (tmp_path / "arm.urdf").read_text()
    foot = '<link name="foot"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>'
    (tmp_path / "arm.urdf").write_text(text.replace('<link name="foot"/>', foot))
    pairs = Clearance(load(str(path))).pairs
    against = {(kind, first.split("_")[0]) for kind, first, second in pairs if second.startswith("larm_foot")}
    assert against == {("to the trunk", "larm"), ("to obstacles", "rarm")}
