"""A constraint on learned folds: the robot must be able to do them.

The value of the constraint is negative if the robot cannot do a fold.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tatamu.base.files import read_bytes
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Reach
from tatamu.robots.catalog import load
from tatamu.robots.description import disturbances_of, files_of
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.placement import Placement
from tatamu.robots.reach import best_placements, search, table_heights
from tatamu.robots.refusal import Refused, out_of_reach, table_too_high

REMEMBERED = 8
"""Number of placements of earlier folds that are tried first. A placement is a pose of the fold on the table.

These placements often suit a new fold, because the trials of one study are similar.
"""


class ReachConstraint:
    """The quality with which a robot can do a fold.

    The poses of earlier folds on the table are tried first, because they often suit the new fold. This makes the
    computation faster.
    """

    def __init__(self, robot: Robot) -> None:
        self._starting = [robot.starting(start) for start in robot.poses]
        self._known: list[tuple[Robot, Placement]] = []

    def __call__(self, manipulation: Manipulation) -> float:
        """Return the quality of a fold's best placement.

        The quality is from 0 (just possible) to 1. It is negative if the robot cannot do the fold.

        Args:
            manipulation: The hands' paths, on Bezier curves.

        Raises:
            InputError: If a hand does not move.
        """
        hands = HandMotion.exact(manipulation)
        for robot, placement in self._known:
            if len(robot.folding) != len(hands.curves):
                continue
            quality = float(search(robot, hands, [placement], fine=True).quality[0])
            if quality >= 0:
                return quality
        return max(self._searched(robot, hands) for robot in self._ways(hands))

    def refusal(self, manipulation: Manipulation) -> str | None:
        """Return why the robot cannot do a fold, or None if the robot can do the fold.

        The placement that is found is not kept for later calls.

        Args:
            manipulation: The hands' paths, on Bezier curves.

        Raises:
            InputError: If a hand does not move.
        """
        hands = HandMotion.exact(manipulation)
        refusals: list[Refused] = []
        for robot in self._ways(hands):
            heights = table_heights(robot)
            if heights is None:
                refusals.append(table_too_high(robot))
                continue
            ranking = best_placements(robot, hands, heights)
            if ranking.good:
                return None
            refusals.append(out_of_reach(robot, hands, ranking))
        return str(max(refusals, key=lambda refusal: refusal.progress))

    def forget(self) -> None:
        """Forget the placements of all earlier folds."""
        self._known = []

    def _ways(self, hands: HandMotion) -> Iterator[Robot]:
        """Yield the robot with each of its start poses.

        If only one hand folds, each arm is tried as the folding arm.
        """
        for robot in self._starting:
            yield from robot.with_hands(len(hands.curves))

    def _searched(self, robot: Robot, hands: HandMotion) -> float:
        heights = table_heights(robot)
        if heights is None:
            return -1.0
        ranking = best_placements(robot, hands, heights)
        if ranking.good:
            self._known = [(robot, ranking.placements[0]), *self._known][:REMEMBERED]
        return float(ranking.quality[0])


def find_reach(name: str) -> Reach:
    """Return the reach of a robot: the manipulations of the cloth that the robot can execute.

    Args:
        name: Name of a robot, or the path of a .toml file that describes a robot.

    Raises:
        InputError: If no robot has this name, or its description is wrong.
    """
    robot = load(name)
    constraint = ReachConstraint(robot)
    files = files_of(Path(name)) if name.endswith(".toml") else []
    own = disturbances_of(Path(name)) if files else None
    return Reach(
        robot.name,
        constraint,
        constraint.refusal,
        constraint.forget,
        description=read_bytes(files[0]) if files else b"",
        files=tuple(files),
        disturbances=own.describe() if own else None,
    )
