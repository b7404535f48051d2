"""Which towels, T-shirts and trousers each robot reaches, for docs/notes/robots.md; below 20 processor minutes.

    python -m benchmarks.presets [--only panda] [--write-docs]

A size counts as reached if one of the typical folds that `tatamu learn --robot` asks for before its first trial is:
in half for towels and T-shirts, leg on leg for trousers. Sizes are tried from the smallest on, until one is out of
reach.
"""

from __future__ import annotations

import time
from typing import Any

from benchmarks.tables import arguments, markdown, merged, publish, published
from tatamu.base.errors import InputError
from tatamu.folding.task import Reach, check_reach, make_task
from tatamu.robots import ReachConstraint, Robot, load
from tatamu.robots.catalog import NAMES

MATERIAL = "polyester"
"""Material so limp that the smallest towel has room for a crease."""
SPACING = 0.04
"""Spacing of the meshes [m]; grasps lie on vertices."""
SIZES = {
    "towel": ("half", ((0.30, 0.20), (0.30, 0.24), (0.34, 0.40), (0.50, 0.70), (0.50, 1.00))),
    "tshirt": ("half", ((0.40, 0.34), (0.54, 0.46), (0.72, 0.56))),
    "trousers": ("leg", ((0.28, 0.45), (0.34, 0.60), (0.44, 1.00))),
}
"""The fold of each garment, and its widths and lengths [m]."""


def reaches(robot: Robot, garment: str, fold: str, size: tuple[float, float]) -> bool:
    """Whether the robot reaches a typical fold of a garment."""
    constraint = ReachConstraint(robot)
    reach = Reach(robot.name, constraint, constraint.refusal)
    task = make_task(garment, size=size, fold=fold, spacing=min(SPACING, size[1] / 4), material=MATERIAL, reach=reach)
    try:
        check_reach(task)
    except InputError:
        return False
    return True


def largest(robot: Robot, garment: str) -> str:
    """Return the sizes of a garment that a robot reaches, as text."""
    fold, sizes = SIZES[garment]
    reached = []
    for size in sizes:
        if not reaches(robot, garment, fold, size):
            break
        reached.append(f"{size[0]:.2f} x {size[1]:.2f}")
    return reached[-1] if reached else "none of these"


def row(name: str) -> dict[str, Any]:
    """The largest sizes that a robot reaches."""
    robot = load(name)
    return {"robot": name, **{f"{garment}, up to [m]": largest(robot, garment) for garment in SIZES}}


def main() -> None:
    """Print the table."""
    parser = arguments(__doc__)
    parser.add_argument("--only", default="", help="a word in the robots' names")
    options = parser.parse_args()
    rows = []
    for name in NAMES:
        if options.only in name:
            begun = time.process_time()
            rows.append(row(name))
            print(rows[-1], f"{time.process_time() - begun:.0f} s", flush=True)
            if options.write_docs:
                publish("presets", markdown(merged(published("presets"), rows, "robot")))
    print(markdown(rows))


if __name__ == "__main__":
    main()
