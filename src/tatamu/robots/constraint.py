"""Reach as a constraint while a fold is learned: a number that is negative where the robot cannot do the fold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tatamu.files import validated
from tatamu.robots.hands import Hands, Manipulation
from tatamu.robots.model import Robot
from tatamu.robots.placement import FINE_HOLDS, Placement
from tatamu.robots.reach import best_placements, search, table_heights
from tatamu.robots.refusal import out_of_reach, table_too_high

REMEMBERED = 8
"""Placements that served earlier folds are tried first: trials of one study are much alike."""


class ReachConstraint:
    """How well a robot can do a fold; what it remembers of earlier folds makes answers faster, not better."""

    def __init__(self, robot: Robot) -> None:
        self._robots = [robot.starting(start) for start in robot.poses]
        self._known: list[tuple[Robot, Placement]] = []

    def __call__(self, manipulation: dict[str, Any]) -> float:
        """The quality of the best placement: from 0, just possible, to 1, comfortable; negative: not possible.

        Args:
            manipulation: What manipulation.json of the fold would hold.

        Raises:
            InputError: It is no manipulation.
        """
        hands = _hands(manipulation)
        for robot, placement in self._known:
            quality = float(search(robot, hands, [placement], FINE_HOLDS).quality[0])
            if quality >= 0:
                return quality
        return max(self._searched(robot, hands) for robot in self._robots)

    def refusal(self, manipulation: dict[str, Any]) -> str | None:
        """Why the robot cannot do a fold, None where it can; asking leaves no memory.

        Args:
            manipulation: What manipulation.json of the fold would hold.

        Raises:
            InputError: It is no manipulation.
        """
        hands, refusals = _hands(manipulation), []
        for robot in self._robots:
            heights = table_heights(robot)
            if heights is None:
                refusals.append(table_too_high(robot))
                continue
            reach = best_placements(robot, hands, heights)
            if reach.good:
                return None
            refusals.append(out_of_reach(robot, hands, reach))
        return str(max(refusals, key=lambda refusal: refusal.progress))

    def _searched(self, robot: Robot, hands: Hands) -> float:
        heights = table_heights(robot)
        if heights is None:
            return -1.0
        reach = best_placements(robot, hands, heights)
        if reach.good:
            self._known = [(robot, reach.placements[0]), *self._known][:REMEMBERED]
        return float(reach.quality[0])


def _hands(manipulation: dict[str, Any]) -> Hands:
    source = Path("manipulation")
    return Hands.of(validated(Manipulation, manipulation, source), source)
