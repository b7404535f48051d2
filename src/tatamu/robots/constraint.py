"""A constraint on learned folds: the robot must be able to do them."""

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
from tatamu.robots.reach import Refused, best_placements, out_of_reach, search, table_heights, table_too_high
from tatamu.simulation.rollout import Rollout

REMEMBERED = 8
"""Number of placements of earlier folds that are tried first, because the trials of one study are similar."""


class ReachConstraint:
    """The quality with which a robot can do a fold."""

    def __init__(self, robot: Robot) -> None:
        self._starting = [robot.starting(start) for start in robot.poses]
        self._known: list[tuple[Robot, Placement]] = []

    def __call__(self, manipulation: Manipulation, cloth: Rollout | None = None) -> float:
        """Return the quality of a fold's best placement, from 0 to 1; negative if the robot cannot do the fold.

        Args:
            manipulation: The hands' paths, on Bezier curves.
            cloth: Simulated motion of the cloth, out of which the hands must stay; None if it is not known.

        Raises:
            InputError: If a hand does not move.
        """
        hands = HandMotion.exact(manipulation)
        for robot, placement in self._known:
            if len(robot.folding) != len(hands.curves):
                continue
            quality = float(search(robot, hands, [placement], fine=True, cloth=cloth).quality[0])
            if quality >= 0:
                return quality
        return max(self._searched(robot, hands, cloth) for robot in self._ways(hands))

    def refusal(self, manipulation: Manipulation) -> str | None:
        """Return why the robot cannot do a fold, or None if it can. Later calls do not depend on this one.

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
        """Yield the robot with each of its start poses."""
        for robot in self._starting:
            yield from robot.with_hands(len(hands.curves))

    def _searched(self, robot: Robot, hands: HandMotion, cloth: Rollout | None) -> float:
        heights = table_heights(robot)
        if heights is None:
            return -1.0
        ranking = best_placements(robot, hands, heights, cloth)
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
