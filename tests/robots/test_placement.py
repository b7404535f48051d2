import numpy as np
import pytest

from tatamu.robots import load
from tatamu.robots.hands import HandMotion
from tatamu.robots.placement import grid
from tatamu.robots.pose import turn
from tests.robots.folds import exact


@pytest.mark.parametrize("degrees", [0, 90, 180, -135])
def test_a_fold_may_go_any_way_in_its_own_frame(degrees: float) -> None:
    """Step 3 of trousers in thirds goes along -x: before the robot its hands shall go ahead all the same."""
    robot = load("hironx")
    hands = HandMotion.exact(exact())
    points = hands.at(hands.evenly(10))
    around = points @ turn(2, np.radians(degrees)).T
    wanted = grid(robot, points, (-0.2, -0.1))
    found = grid(robot, around, (-0.2, -0.1))
    assert len(wanted) == len(found)
    for one, other in zip(wanted, found, strict=True):
        assert np.allclose(_in_base(one.matrix, points), _in_base(other.matrix, around), atol=1e-12)
        assert one.turning == other.turning


def _in_base(X_BF: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ X_BF[:3, :3].T + X_BF[:3, 3]
