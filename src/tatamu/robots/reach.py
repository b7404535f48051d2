"""The placements from which both arms can follow the whole fold, and the best of them.

Each candidate placement is tried with each hold; an arm follows the hand's path from point to point by damped least
squares. Each point starts from the angles of the last one, so a path that would need a jump counts as unreachable. Then
the distances from the trunk and the table, and between both arms, are computed for paths that are reached.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.robots.chain import Chain
from tatamu.robots.clearance import Clearance
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Arm, Robot
from tatamu.robots.placement import (
    ASIDE,
    SHALLOW,
    Hold,
    Placement,
    grid,
    holds_of,
    neighbours,
    tool_paths,
)

SAMPLES = 10
"""Points of the fold that are tried, equally far apart along the hands' paths."""
GOOD_MARGIN = 0.2
"""Distance from joint limits above which placements count as equal [rad]."""
GOOD_SINGULARITY = 0.2
"""Distance from singularities above which placements count as equal; see `Chain.singularity`."""
DISTANCES = {
    "between arms": (0.018, 0.06),
    "to the trunk": (0.008, 0.04),
    "within an arm": (0.008, 0.04),
    "to obstacles": (0.008, 0.04),
    "to the table": (0.003, 0.012),
    "of fingers to the table": (0.0004, 0.0008),
}
"""Less distance than the first is not possible, more than the second counts no further [m]."""
ALONE = ("to the trunk", "within an arm", "to obstacles", "to the table", "of fingers to the table")
"""Kinds of distances that one arm alone decides."""
TABLE_ROOM = 0.01
"""Least distance of a table below the robot at its initial pose [m]."""
ON_THE_WAY = (0.25, 0.5, 0.75)
"""Fractions of the way from the initial pose to the first point, and back from the last, that are also tested."""
HOPELESS = -1.0
"""Worst result whose search continues."""
REFINED = 2
"""Placements, the best first, whose neighbourhoods are searched too."""
ASKED = 80
"""Number of best placements whose distances are computed."""
CLEAR, TRIED = 3, 8
"""Number of collision-free holds that each arm needs, and largest number of holds tried for them."""


@dataclass(frozen=True)
class ArmReach:
    """The motion of one arm along the path of one hand, for every placement and hold."""

    quality: np.ndarray
    """1 is comfortable, 0 just possible, negative not; shape (placements, holds)."""
    reached: np.ndarray
    """Number of points reached in a row, shape (placements, holds)."""
    angles: np.ndarray
    """[rad], shape (placements, holds, points, k)."""

    def best(self, placement: int) -> np.ndarray:
        """Return the best holds, the best first."""
        order = np.argsort(-self.quality[placement], kind="stable")[:CLEAR]
        return order[self.quality[placement][order] > HOPELESS]


@dataclass(frozen=True)
class PlacementRanking:
    """The answer of the search, best placement first."""

    placements: list[Placement]
    holds: list[tuple[Hold, Hold]]
    """Left, right."""
    quality: np.ndarray
    """The worse arm's, shape (n,)."""
    reached: np.ndarray
    """Points that each arm reached in a row, shape (2, n)."""
    times: np.ndarray
    """Simulated time of each point [s]; the first and the last are approach and retreat."""

    @property
    def good(self) -> int:
        """Number of placements from which both arms can follow the fold; they come first."""
        return int((self.quality >= 0).sum())


def table_heights(robot: Robot, given: float | None = None) -> tuple[float, float] | None:
    """Return the range of heights of a table in B [m] that does not touch the robot at its start, or None."""
    lowest = Clearance(robot, kinds=("to the table",)).lowest(robot.initial)
    low, high = robot.table_heights if given is None else (given, given)
    if given is None:
        high = min(high, lowest - TABLE_ROOM)
    return (low, high) if low <= high and low < lowest else None


def best_placements(robot: Robot, hands: HandMotion, heights: tuple[float, float]) -> PlacementRanking:
    """Search the ground before the robot with the table top between two heights in B [m]; the best comes first."""
    chains = Chain.of(robot, robot.larm), Chain.of(robot, robot.rarm)
    points = hands.at(hands.evenly(SAMPLES))
    coarse = search(robot, hands, grid(chains, points, heights, robot.front, robot.trunk is not None))
    around = [
        placement
        for best in coarse.placements[: min(REFINED, int((coarse.quality > HOPELESS).sum()))]
        for placement in neighbours(best, points, heights, robot.front)
    ]
    return joined(coarse, search(robot, hands, around, fine=True))


def joined(first: PlacementRanking, second: PlacementRanking) -> PlacementRanking:
    """Return two results as one, the best first."""
    order = np.argsort(-np.concatenate([first.quality, second.quality]), kind="stable")
    placements, holds = first.placements + second.placements, first.holds + second.holds
    return PlacementRanking(
        [placements[i] for i in order],
        [holds[i] for i in order],
        np.concatenate([first.quality, second.quality])[order],
        np.hstack([first.reached, second.reached])[:, order],
        first.times,
    )


def search(robot: Robot, hands: HandMotion, placements: list[Placement], fine: bool = False) -> PlacementRanking:
    """Try every placement with few or with all holds; the best comes first."""
    times = hands.evenly(SAMPLES)
    if not placements:
        return PlacementRanking([], [], np.empty(0), np.empty((2, 0), dtype=np.int64), times)
    points = hands.at(times)
    trunk = np.stack([place.trunk(points)[[0, *range(SAMPLES), -1]] for place in placements])
    holds = [holds_of(arm, fine) for arm in robot.arms]
    larm, rarm = (
        follow(robot, arm, placements, ways, trunk, path, np.diff(times))
        for arm, ways, path in zip(robot.arms, holds, points, strict=True)
    )
    quality, chosen = _keep_clear(robot, placements, trunk, larm, rarm)
    reached = np.stack([larm.reached.max(axis=1), rarm.reached.max(axis=1)])
    # What cannot be followed is ordered by how far the worse arm came.
    order = np.argsort(-np.where(quality > HOPELESS, 2 + quality, reached.min(axis=0) / 1e3), kind="stable")
    return PlacementRanking(
        [placements[i] for i in order],
        [(holds[0][chosen[0, i]], holds[1][chosen[1, i]]) for i in order],
        quality[order],
        reached[:, order],
        np.concatenate([times[:1], times, times[-1:]]),
    )


def follow(
    robot: Robot,
    arm: Arm,
    placements: list[Placement],
    holds: Sequence[Hold],
    trunk: np.ndarray,
    path: np.ndarray,
    steps: np.ndarray,
) -> ArmReach:
    """Follow one hand's path from every placement.

    Args:
        robot: The robot.
        arm: Its arm.
        placements: Allowed places of the fold.
        holds: Allowed holds of the hem.
        trunk: The trunk's angle from each placement at each point [rad], shape (placements, n + 2).
        path: The hand's path in F [m], shape (n, 3).
        steps: Times between points [s], shape (n - 1,).
    """
    chain = Chain.of(robot, arm)
    shape = (len(placements), len(holds))
    targets = chain.before_trunk(tool_paths(placements, holds, path, arm.jaw), trunk[:, None])
    targets = targets.reshape(-1, len(path) + 2, 4, 4)
    angles, reached = _track(chain, targets, arm.initial)
    whole = np.flatnonzero(reached == targets.shape[1])
    quality = np.full(len(targets), 2 * HOPELESS)
    quality[whole] = _quality(chain, arm, angles[whole], steps)
    shallow = np.array([SHALLOW * (1 - hold.tilt / (np.pi / 2)) + ASIDE * abs(hold.yaw) for hold in holds])
    quality = quality.reshape(shape)
    quality = np.where(quality > 0, quality / (1 + shallow), quality)
    return ArmReach(quality, reached.reshape(shape), angles.reshape(*shape, *angles.shape[1:]))


def _keep_clear(
    robot: Robot, placements: list[Placement], trunk: np.ndarray, larm: ArmReach, rarm: ArmReach
) -> tuple[np.ndarray, np.ndarray]:
    """Ask the most promising placements for distances.

    Returns:
        Quality with distances counted (n,), and the number of each arm's hold (2, n).
    """
    quality = np.minimum(larm.quality.max(axis=1), rarm.quality.max(axis=1))
    chosen = np.stack([larm.quality.argmax(axis=1), rarm.quality.argmax(axis=1)])
    alone = [Clearance(robot, ALONE, arm.name) for arm in robot.arms]
    between = Clearance(robot, ("between arms",))
    promising = np.argsort(-quality, kind="stable")[: int((quality > HOPELESS).sum())]
    quality[promising[ASKED:]] = HOPELESS
    for number in promising[:ASKED]:
        for arm, reach, clearance in zip(robot.arms, (larm, rarm), alone, strict=True):
            clearance.set_table(placements[number].z)
            _alone(robot, arm, clearance, trunk[number], reach.quality[number], reach.angles[number])
        best = _pair(robot, between, larm, rarm, trunk[number], int(number))
        quality[number] = best[0]
        if best[0] > HOPELESS:
            chosen[:, number] = best[1:]
    return quality, chosen


def _alone(
    robot: Robot, arm: Arm, clearance: Clearance, trunk: np.ndarray, quality: np.ndarray, angles: np.ndarray
) -> None:
    """Lower the quality of holds (h,) by the distances of the arm from the trunk, itself and the table.

    The best holds are tested first. Once enough are clear, or too many are not, it stops; the rest count as impossible.
    """
    clear = 0
    for rank, hold in enumerate(np.argsort(-quality, kind="stable")):
        if clear < CLEAR and rank < TRIED and quality[hold] > HOPELESS:
            there_and_back = _from_start(angles[hold], arm.initial), _from_start(trunk, np.zeros(()))
            quality[hold] = min(quality[hold], _room(clearance, _whole(robot, arm, *there_and_back)))
            clear += quality[hold] >= 0
        else:
            quality[hold] = 2 * HOPELESS


def _pair(
    robot: Robot, between: Clearance, larm: ArmReach, rarm: ArmReach, trunk: np.ndarray, number: int
) -> tuple[float, int, int]:
    """Quality of the best pair of holds that keep the arms apart, and their numbers."""
    best = (HOPELESS, 0, 0)
    for left in larm.best(number):
        for right in rarm.best(number):
            quality = min(larm.quality[number, left], rarm.quality[number, right])
            if quality > best[0]:
                one = _from_start(larm.angles[number, left], robot.larm.initial)
                other = _from_start(rarm.angles[number, right], robot.rarm.initial)
                both = robot.configuration(one, other, _from_start(trunk, np.zeros(())))
                quality = min(quality, _room(between, both))
                best = max(best, (float(quality), int(left), int(right)))
    return best


def _from_start(angles: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return angles (m, ..) with some on the way to the first and back from the last, shape (m + 2 n, ..) [rad]."""
    way = np.array(ON_THE_WAY).reshape(-1, *([1] * start.ndim))
    there, back = start + way * (angles[0] - start), start + way[::-1] * (angles[-1] - start)
    return np.concatenate([there, angles, back])


def _room(clearance: Clearance, configurations: np.ndarray) -> float:
    """Return the quality of the smallest distance of configurations (n, nq): at most 1, negative if too near."""
    worst = 1.0
    for kind, found in clearance.least(configurations).items():
        low, high = DISTANCES[kind]
        worst = min(worst, (found.value - low) / (high - low))
    return worst


def _whole(robot: Robot, arm: Arm, angles: np.ndarray, trunk: np.ndarray) -> np.ndarray:
    """Full configurations with only this arm moved (m, k) to (m, nq)."""
    others = [np.broadcast_to(other.initial, (len(angles), len(other.initial))) for other in robot.arms]
    both = zip(robot.arms, others, strict=True)
    larm, rarm = (angles if other is arm else still for other, still in both)
    return robot.configuration(larm, rarm, trunk)


def _track(chain: Chain, targets: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles (n, m, k) along targets (n, m, 4, 4), and how many points in a row were reached (n,)."""
    count, points = targets.shape[:2]
    angles = np.full((count, points, len(start)), np.nan)
    reached = np.zeros(count, dtype=np.int64)
    alive = np.flatnonzero(chain.near(targets[:, :, :3, 3]))
    last = np.tile(start, (len(alive), 1))
    for point in range(points):
        last, there = chain.solve(targets[alive, point], last, steps=25 if point == 0 else 6)
        alive, last = alive[there], last[there]
        angles[alive, point] = last
        reached[alive] = point + 1
    return angles, reached


def _quality(chain: Chain, arm: Arm, angles: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return the smallest margin for angles (n, m, k), reduced for folds that must be slowed down."""
    count, points, width = angles.shape
    margin = chain.margin(angles.reshape(-1, width)).reshape(count, points).min(axis=1) / GOOD_MARGIN
    some = angles[:, ::2]
    singular = chain.singularity(some.reshape(-1, width)).reshape(some.shape[:2]).min(axis=1) / GOOD_SINGULARITY
    return np.minimum(1.0, np.minimum(margin, singular)) / np.sqrt(slowing(arm, angles[:, 1:-1], steps))


def slowing(arm: Arm, angles: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Estimate the factor, at least 1, by which the path (n, m, k) with `steps` (m - 1,) [s] must be slowed down."""
    speed = np.diff(angles, axis=1) / steps[:, None]
    rate = np.diff(speed, axis=1) / ((steps[1:] + steps[:-1]) / 2)[:, None]
    fast = (np.abs(speed) / arm.planned_speed).max(axis=(1, 2))
    hard = (np.abs(rate) / arm.planned_acceleration).max(axis=(1, 2))
    return np.maximum(1.0, np.maximum(fast, np.sqrt(hard)))
