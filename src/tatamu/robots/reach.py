"""Find the placements from which both arms can follow the whole fold, and the best of these placements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from tatamu.robots.arm import Arm
from tatamu.robots.arm_reach import CLEAR, HOPELESS, ArmReach, follow
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
ALONE = tuple(kind for kind in KINDS if kind != "between arms")
"""Kinds of distances that depend on the pose of only one arm."""
ASKED = 80
"""Maximum number of placements for which distances between links are computed."""
SEARCH = 2 * ASKED
"""Number of placements in a whole search, of which half are near the best placements."""
TRIED = 8
"""Maximum number of hand orientations for which an arm's distances are computed at one placement."""


@dataclass(frozen=True)
class PlacementRanking:
    """The result of the search for placements, the best placement first."""

    placements: list[Placement]
    holds: list[tuple[Hold, ...]]
    """Orientation of the hand at each placement, for each arm that folds."""
    quality: np.ndarray
    """Quality of the worse arm at each of the n placements, shape (n,)."""
    reached: np.ndarray
    """Number of points that each arm reached before its first failure, shape (arms, n)."""
    times: np.ndarray
    """Simulated times of the tested points, from approach to retreat [s]."""

    @property
    def good(self) -> int:
        """Number of placements, the first in the lists, from which both arms can follow the fold."""
        return int((self.quality >= 0).sum())


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
) -> PlacementRanking:
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
    coarse = search(robot, hands, grid(robot, points, heights), cloth=cloth, progress=progress)
    half = SEARCH // 2
    around = [
        placement
        for best in coarse.placements[: min(2, int((coarse.quality > HOPELESS).sum()))]
        for placement in neighbours(best, points, heights, robot.front)
    ]
    fine = search(robot, hands, around, fine=True, cloth=cloth, progress=lambda done: progress(half + done))
    quality = np.concatenate([coarse.quality, fine.quality])
    order = np.argsort(-quality, kind="stable")
    placements, holds = coarse.placements + fine.placements, coarse.holds + fine.holds
    return PlacementRanking(
        [placements[i] for i in order],
        [holds[i] for i in order],
        quality[order],
        np.hstack([coarse.reached, fine.reached])[:, order],
        coarse.times,
    )


def first_placement(robot: Robot, hands: HandMotion, heights: tuple[float, float]) -> PlacementRanking:
    """Search placements until there is one from which the robot can do a fold: most often, it lies straight ahead."""
    straight = grid(robot, hands.at(hands.evenly(SAMPLES)), heights, straight=True)
    found = search(robot, hands, straight, fine=True, enough=1)
    return found if found.good else best_placements(robot, hands, heights)


def search(
    robot: Robot,
    hands: HandMotion,
    placements: list[Placement],
    fine: bool = False,
    cloth: Rollout | None = None,
    progress: Progress = lambda done: None,
    enough: int = ASKED,
) -> PlacementRanking:
    """Rate the given placements, and return them in the order of their quality, the best first.

    If `fine` is true, more orientations of the hands are tried. Orientations in which a hand enters the cloth are left
    out, unless there is no other. The search ends as soon as `enough` placements are good.
    """
    times = hands.evenly(SAMPLES)
    if not placements:
        return PlacementRanking([], [], np.empty(0), np.empty((len(robot.folding), 0), dtype=np.int64), times)
    points = hands.at(times)
    trunk = np.stack([place.trunk(points)[[0, *range(SAMPLES), -1]] for place in placements])
    holds = [holds_of(arm, fine) for arm in robot.folding]
    arms = [
        follow(robot, arm, placements, ways, trunk, path, np.diff(times))
        for arm, ways, path in zip(robot.folding, holds, points, strict=True)
    ]
    for arm, ways, found in zip(robot.folding, holds, arms, strict=True):
        clear = clear_holds(robot, arm, hands, ways, cloth)
        if clear.any():
            found.quality[:, ~clear] = 2 * HOPELESS
    quality, chosen = _keep_clear(robot, placements, trunk, arms, progress, enough)
    reached = np.stack([arm.reached.max(axis=1) for arm in arms])
    # Placements from which the fold cannot be followed are ordered by the number of points that the worse arm reached.
    order = np.argsort(-np.where(quality > HOPELESS, 2 + quality, reached.min(axis=0) / 1e3), kind="stable")
    return PlacementRanking(
        [placements[i] for i in order],
        [tuple(ways[number] for ways, number in zip(holds, chosen[:, i], strict=True)) for i in order],
        quality[order],
        reached[:, order],
        np.concatenate([times[:1], times, times[-1:]]),
    )


def _keep_clear(
    robot: Robot, placements: list[Placement], trunk: np.ndarray, arms: list[ArmReach], progress: Progress, enough: int
) -> tuple[np.ndarray, np.ndarray]:
    """Lower the quality of promising placements at which the arms come near each other, themselves or an obstacle."""
    quality = np.min([arm.quality.max(axis=1) for arm in arms], axis=0)
    chosen = np.stack([arm.quality.argmax(axis=1) for arm in arms])
    alone = [Clearance(robot, ALONE, arm.name) for arm in robot.folding]
    between = Clearance(robot, ("between arms",))
    promising = np.argsort(-quality, kind="stable")[: int((quality > HOPELESS).sum())]
    asked, good = promising[:ASKED], 0
    for done, number in enumerate(promising):
        if done >= ASKED or good >= enough:
            quality[promising[done:]] = HOPELESS
            break
        progress(done * ASKED // len(asked))
        for arm, reach, clearance in zip(robot.folding, arms, alone, strict=True):
            clearance.set_table(placements[number].z)
            _alone(robot, arm, clearance, trunk[number], reach.quality[number], reach.angles[number])
        best, ways = _together(robot, between, arms, trunk[number], int(number))
        quality[number] = best
        good += best >= 0
        if best > HOPELESS:
            chosen[:, number] = ways
    return quality, chosen


def _alone(
    robot: Robot, arm: Arm, clearance: Clearance, trunk: np.ndarray, quality: np.ndarray, angles: np.ndarray
) -> None:
    """Lower the quality of hand orientations at which the arm comes close to the trunk, itself or its surroundings."""
    clear = 0
    for rank, hold in enumerate(np.argsort(-quality, kind="stable")):
        if clear < CLEAR and rank < TRIED and quality[hold] > HOPELESS:
            way = [_from_start(angles[hold], arm.initial)]
            moving = robot.configuration(way, _from_start(trunk, np.zeros(())), (arm,))
            quality[hold] = min(quality[hold], _room(clearance, moving))
            clear += quality[hold] >= 0
        else:
            quality[hold] = 2 * HOPELESS


def _together(
    robot: Robot, between: Clearance, arms: list[ArmReach], trunk: np.ndarray, number: int
) -> tuple[float, tuple[int, ...]]:
    """Choose an orientation for each hand so that the arms stay away from each other."""
    best: tuple[float, tuple[int, ...]] = (HOPELESS, ())
    for ways in product(*(arm.best(number) for arm in arms)):
        quality = min(arm.quality[number, way] for arm, way in zip(arms, ways, strict=True))
        if quality > best[0]:
            angles = [
                _from_start(arm.angles[number, way], own.initial)
                for arm, way, own in zip(arms, ways, robot.folding, strict=True)
            ]
            both = robot.configuration(angles, _from_start(trunk, np.zeros(())))
            best = max(best, (float(min(quality, _room(between, both))), tuple(map(int, ways))))
    return best


def _from_start(angles: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return a motion [rad] with three poses each on the way from the initial pose and back to it."""
    way = np.array([0.25, 0.5, 0.75]).reshape(-1, *([1] * start.ndim))
    there, back = start + way * (angles[0] - start), start + way[::-1] * (angles[-1] - start)
    return np.concatenate([there, angles, back])


def _room(clearance: Clearance, configurations: np.ndarray) -> float:
    """Return the quality of a motion, judged by its smallest distances."""
    worst = 1.0
    for kind, found in clearance.least(configurations).items():
        limits = DISTANCES[kind]
        worst = min(worst, (found.value - limits.searched) / (limits.comfortable - limits.searched))
    return worst


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
