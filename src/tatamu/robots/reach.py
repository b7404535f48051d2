"""Find the placements from which both arms can follow the whole fold, and the best of these placements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from tatamu.robots.arm_reach import CLEAR, HOPELESS, ArmReach, follow, from_start
from tatamu.robots.clearance import Clearance
from tatamu.robots.cloth import clear_holds
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.pairs import DISTANCES, KINDS
from tatamu.robots.placement import Hold, Placement, Refused, grid, holds_of, neighbours
from tatamu.simulation.rollout import Rollout

Progress = Callable[[int], object]
"""Function that is told how much of the search for placements is done, up to `SEARCH`."""

SAMPLES = 10
"""Number of points on each hand's path for which the arm's reach is tested."""
POINTS = SAMPLES + 2
"""Number of tested points, from approach to retreat."""
ALONE = tuple(kind for kind in KINDS if kind != "between arms")
"""Kinds of distances that depend on the pose of only one arm."""
ASKED = 80
"""Maximum number of placements for which distances between links are computed."""
SEARCH = 2 * ASKED
"""Number of placements in a whole search, of which half are near the best placements."""
TRIED = 8
"""Maximum number of hand orientations for which an arm's distances are computed at one placement."""


class Rated(NamedTuple):
    """A placement that was tried."""

    placement: Placement
    holds: tuple[Hold, ...]
    """Orientation of the hand, for each arm that folds."""
    quality: float
    """Quality of the worse arm; not negative if all arms can follow the fold."""
    reached: tuple[int, ...]
    """Number of points that each arm reached before its first failure, from approach to retreat."""

    @property
    def is_good(self) -> bool:
        """Whether all arms can follow the fold."""
        return self.quality >= 0


def table_heights(robot: Robot, given: float | None = None) -> tuple[float, float]:
    """Return the range of table heights [m] at which the initial pose is free.

    Raises:
        Refused: If there is no such height.
    """
    lowest = Clearance(robot, kinds=("to the table",)).lowest(robot.initial)
    low, high = robot.table_heights if given is None else (given, given)
    if given is None:
        high = min(high, lowest - 0.01)  # room between the robot's lowest point and the table [m]
    if low <= high and low < lowest:
        return low, high
    raise Refused(
        f"the table top must be below {np.floor(1e3 * lowest) / 1e3:.3f} m, because at its pose '{robot.start}' the "
        "robot reaches down to there",
        lowest - 10,  # below any other refusal; a start pose with higher arms has more progress
    )


def best_placements(
    robot: Robot,
    hands: HandMotion,
    heights: tuple[float, float],
    cloth: Rollout | None = None,
    progress: Progress = lambda done: None,
    place: Sequence[float] | None = None,
    turnings: Sequence[float] = (0.0,),
) -> list[Rated]:
    """Search placements in front of the robot from which it can do a fold, the best first.

    Learning for a robot, planning and datasets all ask this function.

    Args:
        robot: The robot.
        hands: Motion of the hands.
        heights: Lowest and highest table top in the base B [m].
        cloth: Simulated motion of the cloth, out of which the hands stay; None if it is not known.
        progress: Function that is called with how much is done, up to `SEARCH`.
        place: x, y [m] and yaw [rad] of the fold, for which only the height is searched; None to search for all.
        turnings: Values of `Placement.turning` that are tried at the given place.
    """
    if place is not None:
        x, y, yaw = place
        levels = np.linspace(*heights, 1 if heights[0] == heights[1] else 7)
        tried = [Placement(x, y, float(z), yaw, turning) for z in levels for turning in turnings]
        return search(robot, hands, tried, fine=True, cloth=cloth, progress=progress)
    points = hands.at(hands.evenly(SAMPLES))
    on_grid = search(robot, hands, grid(robot, points, heights), cloth=cloth, progress=progress)
    around = [
        placement
        for best in on_grid[:2]
        if best.quality > HOPELESS
        for placement in neighbours(best.placement, points, heights, robot.front)
    ]
    half = SEARCH // 2
    fine = search(robot, hands, around, fine=True, cloth=cloth, progress=lambda done: progress(half + done))
    return sorted([*on_grid, *fine], key=lambda rated: -rated.quality)


def first_placement(robot: Robot, hands: HandMotion, heights: tuple[float, float]) -> list[Rated]:
    """Search placements until there is one from which the robot can do a fold: most often, it lies straight ahead."""
    straight = grid(robot, hands.at(hands.evenly(SAMPLES)), heights, straight=True)
    found = search(robot, hands, straight, fine=True, enough=1)
    return found if found and found[0].is_good else best_placements(robot, hands, heights)


def search(
    robot: Robot,
    hands: HandMotion,
    placements: list[Placement],
    fine: bool = False,
    cloth: Rollout | None = None,
    progress: Progress = lambda done: None,
    enough: int = ASKED,
) -> list[Rated]:
    """Rate the given placements, and return them in the order of their quality, the best first.

    If `fine` is true, more orientations of the hands are tried. Orientations in which a hand enters the cloth are left
    out, unless there is no other. The search ends as soon as `enough` placements are good.
    """
    if not placements:
        return []
    times = hands.evenly(SAMPLES)
    points = hands.at(times)
    trunk = np.stack([place.trunk(points)[[0, *range(SAMPLES), -1]] for place in placements])
    arms = [
        follow(robot, arm, placements, holds_of(arm, fine), trunk, path, np.diff(times))
        for arm, path in zip(robot.folding, points, strict=True)
    ]
    for reach in arms:
        clear = clear_holds(robot, reach.arm, hands, reach.holds, cloth)
        if clear.any():
            reach.quality[:, ~clear] = 2 * HOPELESS
    found = [
        Rated(
            placement,
            tuple(reach.holds[reach.quality[number].argmax()] for reach in arms),
            float(min(reach.quality[number].max() for reach in arms)),
            tuple(int(reach.reached[number].max()) for reach in arms),
        )
        for number, placement in enumerate(placements)
    ]
    _keep_clear(robot, found, arms, trunk, progress, enough)
    # Placements from which the fold cannot be followed are ordered by the number of points that the worse arm reached.
    return sorted(found, key=lambda each: -(2 + each.quality if each.quality > HOPELESS else min(each.reached) / 1e3))


def _keep_clear(
    robot: Robot, found: list[Rated], arms: list[ArmReach], trunk: np.ndarray, progress: Progress, enough: int
) -> None:
    """Lower the quality of promising placements at which the arms come near each other, themselves or an obstacle."""
    alone = [Clearance(robot, ALONE, reach.arm.name) for reach in arms]
    between = Clearance(robot, ("between arms",))
    promising = [number for number, each in enumerate(found) if each.quality > HOPELESS]
    good = 0
    for done, number in enumerate(sorted(promising, key=lambda number: -found[number].quality)):
        quality, holds = HOPELESS, found[number].holds
        if done < ASKED and good < enough:
            progress(done * ASKED // min(len(promising), ASKED))
            turned = from_start(trunk[number], 0.0)
            for reach, clearance in zip(arms, alone, strict=True):
                clearance.set_table(found[number].placement.z)
                _alone(robot, reach, clearance, turned, number)
            quality, chosen = _together(robot, between, arms, turned, number)
            holds = chosen or holds
            good += quality >= 0
        found[number] = found[number]._replace(quality=quality, holds=holds)


def _alone(robot: Robot, reach: ArmReach, clearance: Clearance, trunk: np.ndarray, number: int) -> None:
    """Lower the quality of hand orientations at which the arm comes close to the trunk, itself or its surroundings."""
    quality, clear = reach.quality[number], 0
    for rank, hold in enumerate(np.argsort(-quality, kind="stable")):
        if clear < CLEAR and rank < TRIED and quality[hold] > HOPELESS:
            moving = robot.configuration([reach.way(number, hold)], trunk, (reach.arm,))
            quality[hold] = min(quality[hold], _room(clearance, moving))
            clear += quality[hold] >= 0
        else:
            quality[hold] = 2 * HOPELESS


def _together(
    robot: Robot, between: Clearance, arms: list[ArmReach], trunk: np.ndarray, number: int
) -> tuple[float, tuple[Hold, ...]]:
    """Choose an orientation for each hand so that the arms stay away from each other; none if the arms always touch."""
    best: tuple[float, tuple[int, ...]] = (HOPELESS, ())
    for ways in product(*(reach.best(number) for reach in arms)):
        each = list(zip(arms, ways, strict=True))
        quality = min(float(reach.quality[number, way]) for reach, way in each)
        if quality > best[0]:
            both = robot.configuration([reach.way(number, way) for reach, way in each], trunk)
            best = max(best, (min(quality, _room(between, both)), ways))
    return best[0], tuple(reach.holds[way] for reach, way in zip(arms, best[1], strict=False))


def _room(clearance: Clearance, configurations: np.ndarray) -> float:
    """Return the quality of a motion, judged by its smallest distances."""
    worst = 1.0
    for kind, found in clearance.least(configurations).items():
        limits = DISTANCES[kind]
        worst = min(worst, (found.value - limits.searched) / (limits.comfortable - limits.searched))
    return worst


def out_of_reach(robot: Robot, hands: HandMotion, best: Rated) -> Refused:
    """Return an error for a fold that the robot cannot follow even at the best placement."""
    reached = min(best.reached)
    if reached == POINTS:
        who = f"{robot.alone} would touch something at every place that it reaches"
        both = "the arms would touch something at every place that both reach"
        return Refused(f"{who if robot.alone else both}; the best place is {best.placement}", -0.5)
    worst = robot.folding[best.reached.index(reached)]
    times = hands.evenly(SAMPLES)
    frame = hands.frame(float(times[np.clip(reached - 1, 0, SAMPLES - 1)]))
    length = np.linalg.norm(hands.curves[0].control[3] - hands.curves[0].control[0])
    return Refused(
        f"{worst.name} cannot follow its hand beyond frame {frame} of the fold, which spans {1e3 * length:.0f} mm, "
        f"even at the best place ({best.placement})",
        reached / (POINTS - 1) - 2,
    )
