"""Which towels and T-shirts each preset reaches, facing and side by side, for docs/notes/robots.md; half an hour.

    python -m benchmarks.presets [--only panda] [--write-docs]

A size counts as reached if one of the typical folds that `tatamu learn --robot` asks for before its first trial is.
"""

from __future__ import annotations

import argparse
from typing import Any

from benchmarks.tables import markdown, publish

from tatamu.errors import InputError
from tatamu.folding.task import Reach, make_task
from tatamu.robots import ReachConstraint, Robot
from tatamu.robots.presets import PAIRS, Mount, facing, pair_of_arms, side_by_side
from tatamu.study.reachable import check_reach

SPACING = 0.03
"""Of the meshes [m]: grasps lie on vertices."""
SIZES = {
    "towel": ((0.34, 0.40), (0.50, 0.34), (0.34, 0.80), (0.50, 0.70), (0.50, 1.00), (0.70, 1.40)),
    "tshirt": ((0.40, 0.34), (0.54, 0.46), (0.66, 0.50), (0.72, 0.56)),
}
"""Width and length [m]."""


def reaches(robot: Robot, garment: str, size: tuple[float, float]) -> bool:
    """Whether the robot reaches a typical fold of a garment in half."""
    constraint = ReachConstraint(robot)
    reach = Reach(robot.name, constraint, constraint.refusal, constraint.forget)
    try:
        check_reach(make_task(garment, size=size, spacing=SPACING, reach=reach))
    except InputError:
        return False
    return True


def row(name: str, words: str, mount: Mount) -> dict[str, Any]:
    """The sizes that a pair reaches on a mount."""
    robot = pair_of_arms(name, PAIRS[name][0], mount)
    found: dict[str, Any] = {"pair": name, "mount": words}
    for garment, sizes in SIZES.items():
        reached = [f"{width:.2f} x {length:.2f}" for width, length in sizes if reaches(robot, garment, (width, length))]
        found[f"{garment} [m]"] = ", ".join(reached) or "none"
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="a word in the presets' names")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    rows = []
    for name, (_, own) in PAIRS.items():
        if options.only not in name:
            continue
        mounts = {
            f"facing, feet {2 * own.y:.1f} m apart": facing(own.y, own.front),
            "side by side, feet 0.6 m apart": side_by_side(0.3),
        }
        for words, mount in mounts.items():
            rows.append(row(name, words, mount))
            print(rows[-1], flush=True)
    print(markdown(rows))
    if options.write_docs:
        publish("presets", markdown(rows))


if __name__ == "__main__":
    main()
