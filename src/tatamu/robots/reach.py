"""Find the placements from which both arms can follow the whole fold, and the best of these placements.

Each candidate placement is tried with each orientation of the hands (`arm_reach`). If both arms reach their paths, the
distances are computed: to the trunk, to the table, and between the arms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from tatamu.robots.arm_reach import CLEAR, HOPELESS, ArmReach, follow
from tatamu.robots.chain import Chain
from tatamu.robots.clearance import Clearance
from tatamu.robots.cloth import clear_holds
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Arm, Robot
from tatamu.robots.placement import Hold, Placement, grid, holds_of, neighbours
from tatamu.simulation.rollout import Rollout

Progress = Callable[[int], object]
"""Function that is told how much of the search for placements is done, up to `SEARCH`."""

SAMPLES = 10
"""Number of points on each hand's path for which the arm's reach is tested.

The points divide the path into equal lengths.
"""
DISTANCES = {
    "between arms": (0.018, 0.06),
    "to the trunk": (0.008, 0.04),
    "within an arm": (0.008, 0.04),
    "to obstacles": (0.008, 0.04),
    "to the table": (0.003, 0.012),
    "of fingers to the table": (0.0004, 0.0008),
}
"""Two limits [m] for each kind of distance, such as "between arms".

If the distance is below the first limit, the motion counts as impossible. Above the second limit, a larger distance
does not improve the quality of the motion.
"""
ALONE = ("to the trunk", "within an arm", "to obstacles", "to the table", "of fingers to the table")
"""Kinds of distances that depend on the pose of only one arm."""
TABLE_ROOM = 0.01
"""Smallest allowed height of the robot's lowest point above the table in the initial pose [m]."""
ON_THE_WAY = (0.25, 0.5, 0.75)
"""Poses between the initial pose and the fold for which distances are also computed.

Each pose is given as a fraction of the way from the initial pose to the fold.
"""
REFINED = 2
"""Number of the best placements around which further placements are tried."""
ASKED = 80
"""Largest number of placements for which distances between links are computed.

The placements with the best quality are chosen.
"""
SEARCH = 2 * ASKED
"""Number of placements in a whole search, of which half are near the best placements."""
TRIED = 8
"""Largest number of hand orientations for which an arm's distances are computed at one placement.

Fewer are enough if `CLEAR` orientations touch nothing.
"""


@dataclass(frozen=True)
class PlacementRanking:
    """The result of the search for placements, the best placement first."""

    placements: list[Placement]
    holds: list[tuple[Hold, ...]]
    """Orientation of the hand at each placement, for each arm that folds."""
    quality: np.ndarray
    """Quality of the worse arm at each of the n placements, shape (n,)."""
    reached: np.ndarray
    """Number of points that each arm reached before its first failure at each placement, shape (arms, n)."""
    times: np.ndarray
    """Simulated time of each tested point of the fold [s].

    The first point is the approach, the last point is the retreat.
    """

    @property
    def good(self) -> int:
        """Number of placements from which both arms can follow the fold.

        These placements are the first in the lists.
        """
        return int((self.quality >= 0).sum())


def silent(done: int) -> None:
    """Report nothing."""


def table_heights(robot: Robot, given: float | None = None) -> tuple[float, float] | None:
    """Return the range of table heights at which the table does not touch the robot in its initial pose [m].

    The heights are in the base B. Return None if a table at every allowed height would touch the robot.
    """
    lowest = Clearance(robot, kinds=("to the table",)).lowest(robot.initial)
    low, high = robot.table_heights if given is None else (given, given)
    if given is None:
        high = min(high, lowest - TABLE_ROOM)
    return (low, high) if low <= high and low < lowest else None


def best_placements(
    robot: Robot,
    hands: HandMotion,
    heights: tuple[float, float],
    cloth: Rollout | None = None,
    progress: Progress = silent,
) -> PlacementRanking:
    """Search placements in front of the robot from which it can do a fold, the best first.

    Learning for a robot and planning both ask this function.

    Args:
        robot: The robot.
        hands: Motion of the hands.
        heights: Lowest and highest table top in the base B [m].
        cloth: Simulated motion of the cloth, out of which the hands stay; None if it is not known.
        progress: Function that is called with how much is done, up to `SEARCH`.
    """
    chains = tuple(Chain.of(robot, arm) for arm in robot.folding)
    points = hands.at(hands.evenly(SAMPLES))
    places = grid(chains, points, heights, robot.front, robot.trunk is not None)
    coarse = search(robot, hands, places, cloth=cloth, progress=progress)
    half = SEARCH // 2
    around = [
        placement
        for best in coarse.placements[: min(REFINED, int((coarse.quality > HOPELESS).sum()))]
        for placement in neighbours(best, points, heights, robot.front)
    ]
    fine = search(robot, hands, around, fine=True, cloth=cloth, progress=lambda done: progress(half + done))
    return joined(coarse, fine)


def joined(first: PlacementRanking, second: PlacementRanking) -> PlacementRanking:
    """Return the results of two searches as one result, the best placement first."""
    order = np.argsort(-np.concatenate([first.quality, second.quality]), kind="stable")
    placements, holds = first.placements + second.placements, first.holds + second.holds
    return PlacementRanking(
        [placements[i] for i in order],
        [holds[i] for i in order],
        np.concatenate([first.quality, second.quality])[order],
        np.hstack([first.reached, second.reached])[:, order],
        first.times,
    )


def search(
    robot: Robot,
    hands: HandMotion,
    placements: list[Placement],
    fine: bool = False,
    cloth: Rollout | None = None,
    progress: Progress = silent,
) -> PlacementRanking:
    """Rate the given placements, and return them in the order of their quality, the best first.

    If `fine` is true, more orientations of the hands are tried. Orientations in which a hand enters the cloth are left
    out, unless there is no other.
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
    quality, chosen = _keep_clear(robot, placements, trunk, arms, progress)
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
    robot: Robot, placements: list[Placement], trunk: np.ndarray, arms: list[ArmReach], progress: Progress
) -> tuple[np.ndarray, np.ndarray]:
    """Lower the quality of promising placements at which the arms come near each other, themselves or an obstacle.

    Returns:
        Two arrays for n placements: the quality, which now depends on the distances, shape (n,), and the number of the
        chosen orientation of each arm's hand, shape (arms, n).
    """
    quality = np.min([arm.quality.max(axis=1) for arm in arms], axis=0)
    chosen = np.stack([arm.quality.argmax(axis=1) for arm in arms])
    alone = [Clearance(robot, ALONE, arm.name) for arm in robot.folding]
    between = Clearance(robot, ("between arms",))
    promising = np.argsort(-quality, kind="stable")[: int((quality > HOPELESS).sum())]
    quality[promising[ASKED:]] = HOPELESS
    asked = promising[:ASKED]
    for done, number in enumerate(asked):
        progress(done * ASKED // len(asked))
        for arm, reach, clearance in zip(robot.folding, arms, alone, strict=True):
            clearance.set_table(placements[number].z)
            _alone(robot, arm, clearance, trunk[number], reach.quality[number], reach.angles[number])
        best, ways = _together(robot, between, arms, trunk[number], int(number))
        quality[number] = best
        if best > HOPELESS:
            chosen[:, number] = ways
    return quality, chosen


def _alone(
    robot: Robot, arm: Arm, clearance: Clearance, trunk: np.ndarray, quality: np.ndarray, angles: np.ndarray
) -> None:
    """Lower the quality of hand orientations at which the arm comes near the trunk, itself, an obstacle or the table.

    The best orientations are tested first. The test stops when enough orientations touch nothing, or when too many have
    been tested. The remaining orientations count as impossible.
    """
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
    """Choose an orientation for each hand so that the arms stay away from each other.

    Return the best quality that is possible, and the numbers of the chosen orientations.
    """
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
    """Return a motion [rad] that starts and ends at the initial pose.

    The array `angles` has the motion's m rows. Before them, n rows are added from `start`, the initial pose, to the
    first row. After them, n rows are added from the last row back to `start`. The result therefore has m + 2 n rows.
    """
    way = np.array(ON_THE_WAY).reshape(-1, *([1] * start.ndim))
    there, back = start + way * (angles[0] - start), start + way[::-1] * (angles[-1] - start)
    return np.concatenate([there, angles, back])


def _room(clearance: Clearance, configurations: np.ndarray) -> float:
    """Return the quality of a motion, judged by its smallest distances.

    The distances are computed in n configurations, shape (n, nq). The quality is at most 1. It is negative if a
    distance is too small.
    """
    worst = 1.0
    for kind, found in clearance.least(configurations).items():
        low, high = DISTANCES[kind]
        worst = min(worst, (found.value - low) / (high - low))
    return worst
