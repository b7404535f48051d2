"""Load robots by name or from a description file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.robots.assembly import described
from tatamu.robots.kawada import kawada
from tatamu.robots.model import Robot
from tatamu.robots.presets import PAIRS, pair_of_arms
from tatamu.robots.soundness import check_kinematics

NAMED: dict[str, Callable[[float | None, float | None], Robot]] = {
    "hironx": lambda wrist, tip: kawada("hironx", wrist, tip),
    "nextage": lambda wrist, tip: kawada("nextage", wrist, tip, nextage=True),
}


def load(name: str, wrist_offset: float | None = None, fingertip: float | None = None) -> Robot:
    """Load a robot by name or from a TOML file.

    Args:
        name: A name in `NAMED` or `PAIRS`, or the path of a description (see docs/reference/robot-description.md).
        wrist_offset: Distance from joint J4 to joint J5 along x [m]; only for HIRONX and NEXTAGE Open, see `kawada`.
        fingertip: Distance from the last joint to the fingertip [m]; only for HIRONX and NEXTAGE Open, see `kawada`.

    Raises:
        InputError: If no robot has this name, or the description is wrong.
    """
    robot = _named(name, wrist_offset, fingertip)
    check_kinematics(robot)
    return robot


def _named(name: str, wrist_offset: float | None, fingertip: float | None) -> Robot:
    if name in NAMED:
        return NAMED[name](wrist_offset, fingertip)
    if name not in PAIRS and not name.endswith(".toml"):
        names = ", ".join((*NAMED, *PAIRS))
        raise InputError(f"robot: must be {names}, or a .toml file that describes one, given {name!r}")
    if wrist_offset is not None or fingertip is not None:
        raise InputError("wrist offset and fingertip: only for hironx and nextage; others say it in their .toml")
    return pair_of_arms(name, *PAIRS[name]) if name in PAIRS else described(Path(name))
