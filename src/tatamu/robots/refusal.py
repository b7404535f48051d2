"""Reasons why a robot cannot do a fold."""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import TatamuError
from tatamu.robots.clearance import Clearance
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.reach import PlacementRanking


class Refused(TatamuError):
    """An error: a placement was refused.

    `progress` is larger if planning succeeded in more steps before the error.
    """

    def __init__(self, message: str, progress: float) -> None:
        super().__init__(message)
        self.progress = progress


def table_too_high(robot: Robot) -> Refused:
    """Return an error for a table that would touch the robot at its initial pose."""
    lowest = Clearance(robot, kinds=("to the table",)).lowest(robot.initial)
    return Refused(
        f"the table top must be below {np.floor(1e3 * lowest) / 1e3:.3f} m: at its pose '{robot.start}' the robot "
        "reaches down to there",
        lowest - 10,  # below any other refusal; a start pose with higher arms has more progress
    )


def out_of_reach(robot: Robot, hands: HandMotion, reach: PlacementRanking) -> Refused:
    """Return an error for a fold that the robot cannot follow even at the best placement."""
    placement, reached = reach.placements[0], reach.reached[:, 0]
    last = len(reach.times) - 1
    if reached.min() > last:
        who = f"{robot.alone} would touch something wherever it reaches"
        both = "the arms would touch something wherever both reach"
        return Refused(f"{who if robot.alone else both}; least at {placement}", -0.5)
    worst = int(reached.argmin())
    frame = hands.frame(float(reach.times[reached[worst]]))
    length = np.linalg.norm(hands.curves[0].control[3] - hands.curves[0].control[0])
    return Refused(
        f"{robot.folding[worst].name} cannot follow its hand beyond frame {frame} of the fold, "
        f"{1e3 * length:.0f} mm long, even at the best place ({placement})",
        float(reached.min()) / last - 2,
    )
