import re
from pathlib import Path

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.robots import load, plan_fold
from tatamu.robots.chain import Chain
from tests.refusals import refusal
from tests.robots.arms import pair, urdf
from tests.robots.folds import folder


def test_two_single_arms_make_a_pair_that_plans(tmp_path: Path) -> None:
    robot = load(str(pair(tmp_path)))
    plan = plan_fold(folder(tmp_path / "fold"), robot)
    assert all(check.ok for check in plan.checks.values())
    assert robot.joints[0] == "larm_pan" and robot.joints[6] == "rarm_pan"


def test_arms_of_one_model_that_share_a_joint_are_refused(tmp_path: Path) -> None:
    path = pair(tmp_path)
    text = re.sub(r"(?m)^(model|mount) = .*\n", "", path.read_text())
    path.write_text('model = "arm.urdf"\n' + text)
    with pytest.raises(InputError, match=r"rarm.joints: pan already belongs to larm"):
        load(str(path))


def test_an_arm_without_collision_shapes_is_refused(tmp_path: Path) -> None:
    path = pair(tmp_path)
    (tmp_path / "arm.urdf").write_text(re.sub("<collision>.*?</collision>", "", urdf()))
    with pytest.raises(InputError, match="larm: must have collision shapes"):
        load(str(path))


def test_the_urdf_arm_and_the_mjcf_arm_are_one_arm(tmp_path: Path) -> None:
    robot = load(str(pair(tmp_path)))
    angles = np.array([[0.3, -0.2, 1.1, 0.4, 0.5, -0.6]])
    left, right = (Chain.of(robot, arm).tool(angles)[0][0] for arm in robot.arms)
    assert np.allclose(left[:3, :3], right[:3, :3], atol=1e-9)
    assert np.allclose(left[:3, 3] - right[:3, 3], [0, 0.5, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('model = "arm.urdf"', 'model = "gone.urdf"', "gone.urdf"),
        ('link = "turn_link"', 'link = "hand"', "must name a body"),
        ('"elbow"', '"knee"', "must name a joint"),
        ("speed = [2.0, ", "speed = [", "speed must have one value for each"),
        ("initial = [0.0, -0.2, 1.9", "initial = [0.0, -0.2, 9.9", "must be from"),
        ("front = 0.15", "fornt = 0.15", "fornt"),
        ('name = "pair"', 'name = "pair"\nbase = "foot"', "base must be"),
        (
            'name = "pair"',
            'name = "pair"\ntable_heights = [0.2, -0.1]',
            r"table_heights must be \[minimum, maximum\] with minimum <= maximum, given \[0.2, -0.1\]",
        ),
        (
            '"pan", "lift"',
            '"lift", "pan"',
            "larm.joints: must be in the order from the base to the hand: pan, lift, elbow",
        ),
        ('"pan", "lift"', '"pan", "pan"', "larm: joints must not contain the same name twice"),
        ('link = "turn_link"', 'link = "roll_link"', "larm.joints: must move roll_link, given bend"),
    ],
)
def test_a_wrong_description_names_its_field(tmp_path: Path, old: str, new: str, named: str) -> None:
    path = pair(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    assert re.search(named, refusal(load, str(path)))
