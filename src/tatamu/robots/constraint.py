"""A constraint on learned folds: the robot must be able to do them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from tatamu.base.files import read_bytes
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Reach
from tatamu.robots.catalog import load
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.placement import Refused
from tatamu.robots.reach import first_placement, out_of_reach, table_heights


@dataclass(frozen=True)
class ReachConstraint:
    """Whether a robot can do a fold. The answer depends on the fold alone."""

    robot: Robot

    def __call__(self, manipulation: Manipulation) -> float:
        """Return the quality of a placement for a fold, from 0 to 1; negative if the robot cannot do the fold.

        Raises:
            InputError: If a hand does not move.
        """
        return max(quality for quality, _ in self._answers(HandMotion.exact(manipulation)))

    def refusal(self, manipulation: Manipulation) -> str | None:
        """Return why the robot cannot do a fold, or None if it can.

        Raises:
            InputError: If a hand does not move.
        """
        refusals = [refusal for _, refusal in self._answers(HandMotion.exact(manipulation))]
        if None in refusals:
            return None
        return str(max(filter(None, refusals), key=lambda refusal: refusal.progress))

    @cached_property
    def _ways(self) -> dict[int, list[Robot]]:
        """The robot in each of its start poses, by the number of hands, so that each model is compiled once."""
        return {hands: self.robot.ways(hands) for hands in (1, 2)}

    def _answers(self, hands: HandMotion) -> Iterator[tuple[float, Refused | None]]:
        """Yield the quality from each start pose, and why it is negative, until the robot can do the fold."""
        for robot in self._ways[len(hands.curves)]:
            try:
                best = first_placement(robot, hands, table_heights(robot))[0]
            except Refused as error:
                yield -1.0, error
                continue
            yield best.quality, None if best.is_good else out_of_reach(robot, hands, best)
            if best.is_good:
                return


def find_reach(name: str) -> Reach:
    """Return the reach of a robot: the manipulations of the cloth that the robot can execute.

    Args:
        name: Name of a robot, or the path of a .toml file that describes a robot.

    Raises:
        InputError: If no robot has this name, or its description is wrong.
    """
    robot = load(name)
    constraint = ReachConstraint(robot)
    files = robot.files if name.endswith(".toml") else ()
    return Reach(
        robot.name,
        constraint,
        constraint.refusal,
        description=read_bytes(files[0]) if files else b"",
        files=files,
        disturbances=robot.disturbances.describe() if robot.disturbances else None,
    )
