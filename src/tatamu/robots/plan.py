"""A robot plan: the placement of the fold, the motion of the robot, and the results of its checks.

    task ──▶ paths ──▶ motion ──▶ checks ──▶ plan

The search proposes placements, the best first. The first placement whose checks all pass becomes the plan.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.robots.checks import Checks, failing
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.motion import Motion, Pace, motion
from tatamu.robots.paths import Paths, PlacedFold, cloth_of
from tatamu.robots.placement import Refused
from tatamu.robots.planfile import FingerEvent, GripperCommand, PlanCheck, Segment
from tatamu.robots.reach import POINTS, SEARCH, Rated, best_placements, out_of_reach, table_heights
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result

CANDIDATES = 12
"""Maximum number of placements for which a whole plan is computed.

If none of these plans passes its checks, the fold is refused.
"""


SHUT = 0.0
"""Width to which the jaws are commanded when they grip cloth, which stops them earlier [m]."""


class NoPlacement(InputError):
    """An error: the robot cannot do the fold from any placement in front of it."""


@dataclass(frozen=True)
class RobotPlan:
    """A motion of the robot that passed all checks."""

    task: PlacedFold
    motion: Motion
    checks: dict[str, PlanCheck]
    reach: list[Rated] | None
    """Result of the search for placements; None if the user gave the placement."""

    @property
    def gripper_commands(self) -> tuple[GripperCommand, ...]:
        """Commands to the grippers in the order of time.

        The jaws open at the start, close at the event `close` and open again at the event `open`.
        """
        names = ("lead",) if self.task.hover else ("lead", "close", "open")
        return tuple(
            GripperCommand.model_validate(
                {
                    "time": round(stage.start, 6),
                    "arm": arm.name,
                    "width": SHUT if stage.name == "close" else arm.jaw.opening,
                    "force": arm.jaw.force,
                    "duration": round(stage.timed.duration, 6),
                }
            )
            for stage in map(self.motion.part, names)
            for arm in self.task.robot.folding
        )

    @property
    def events(self) -> tuple[FingerEvent, ...]:
        """Times at which fingers close and open; empty if the motion only hovers above the table."""
        arms = len(self.task.robot.folding)
        words = ["close"] * arms + ["open"] * arms
        commands = zip(words, self.gripper_commands[arms:], strict=False)
        return tuple(FingerEvent(time=each.time, arm=each.arm, event=word) for word, each in commands)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The parts of the motion. A program that plays the motion can stop between two parts."""
        closing, opening = self.motion.part("close"), self.motion.part("open")
        end = max(part.end for part in self.motion.parts)
        spans = (("approach", 0.0, closing.start), ("fold", closing.end, opening.start), ("leave", opening.end, end))
        then = ("", "", "") if self.task.hover else ("close", "open", "")
        return tuple(
            Segment.model_validate({"name": name, "start": round(a, 6), "duration": round(b - a, 6), "then": word})
            for (name, a, b), word in zip(spans, then, strict=True)
        )


def plan_fold(
    fold: Result | Path,
    robot: Robot,
    place: tuple[float, float, float] | None = None,
    table_height: float | None = None,
    pace: Pace | None = None,
    hover: float = 0.0,
    progress: Callable[[int, int], object] = lambda done, total: None,
) -> RobotPlan:
    """Plan the motion of a robot for a learned fold.

    Args:
        fold: The learned fold, or its folder.
        robot: The robot.
        place: x, y [m] and yaw [rad] of the fold's frame in the robot's base; None to search for them.
        table_height: Height of the table top in the robot's base [m]; None to search for it.
        pace: Speeds and waiting times of the motion.
        hover: Height above the table at which the robot makes the motion with open jaws [m]; 0 to fold.
        progress: Function that is called with the number of tested placements and the number of all.

    Raises:
        NoPlacement: If the robot cannot do the fold from any placement; the message has the reason.
        InputError: If the folder is not a learned fold, or the robot cannot do the fold from the given place.
    """
    folder = fold.folder if isinstance(fold, Result) else fold
    hands = HandMotion.of(fold) if isinstance(fold, Result) else HandMotion.load(fold)
    source = fold if isinstance(fold, Result) and folder is None else ResultFolder(Path(folder or "."))
    name = folder or "fold"
    refusals: list[Refused] = []
    starts = robot.ways(len(hands.curves))
    for number, starting in enumerate(starts):

        def searched(done: int, before: int = SEARCH * number) -> None:
            progress(before + done, SEARCH * len(starts))

        try:
            heights = table_heights(starting, table_height)
        except Refused as error:
            refusals.append(error)
            continue
        turnings = (0.0, 0.6, 1.0) if robot.trunk else (0.0,)
        reach = best_placements(starting, hands, heights, cloth_of(source), searched, place, turnings)
        tried = [each for each in reach[:CANDIDATES] if each.is_good]
        if not tried:
            refusals.append(out_of_reach(starting, hands, reach[0]))
            tried = [each for each in reach[:1] if min(each.reached) == POINTS]  # if the arms reach all, one is planned
        for each in tried:
            task = PlacedFold(starting, hands, each.placement, each.holds, source)
            try:
                found = _worked_out(task, pace or Pace(), reach if place is None else None)
                return found if not hover else _hovering(found, hover, pace or Pace())
            except Refused as error:
                refusals.append(error)
    best = max(refusals, key=lambda refusal: refusal.progress)
    if place is not None:
        raise InputError(f"{name}: the robot cannot do the fold at this place: {best}")
    arms = "both arms" if len(hands.curves) > 1 else "an arm"
    raise NoPlacement(f"{name}: no placement in front of the robot lets {arms} do the fold: {best}")


def _hovering(plan: RobotPlan, height: float, pace: Pace) -> RobotPlan:
    """Return the same plan with its motion raised above the table. The placement of the fold is the same."""
    try:
        return _worked_out(plan.task.hovering(height), pace, plan.reach)
    except Refused as error:
        raise InputError(
            f"hover: the robot cannot do the fold at a height of {height:g} m ({plan.task.placement}): {error}; give a "
            "lower height, or another place"
        ) from None


def _worked_out(task: PlacedFold, pace: Pace, reach: list[Rated] | None) -> RobotPlan:
    paths = Paths(task)
    stages = paths.stages(pace.lower_speed, pace.raise_speed)
    driven = motion(task.robot, task.hands, stages, pace, task.hover > 0)
    checks = Checks(task, paths, driven).all()
    bad = failing(checks)
    if bad:
        raise Refused(f"{bad[1].failed(bad[0])} ({task.placement})", 1.0)
    return RobotPlan(task, driven, checks, reach)
