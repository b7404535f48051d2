"""The reachability picture: the ground before the robot from above, as SVG that opens anywhere.

Each square is a place for the middle of the fold, at the chosen height and turn: green where both arms do the whole
fold with room to spare, yellow where just so, red where not. The lines are the hands' paths at the chosen place.
"""

from __future__ import annotations

from html import escape

import numpy as np

from tatamu.robots.chain import Chain
from tatamu.robots.plan import RobotPlan

SCALE = 900.0
"""Pixels per metre."""
LEFT, RIGHT, NEAR, FAR = 0.55, -0.55, -0.15, 0.85
"""What is shown: y and x of B [m]; x points up and y to the left, as the robot sees it from behind."""
CELL = 0.034
COLOURS = {"larm": "#1f5fa8", "rarm": "#b5472b"}


def reach_svg(plan: RobotPlan) -> str:
    """The picture of a plan, as text."""
    width, height = SCALE * (LEFT - RIGHT), SCALE * (FAR - NEAR)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height + 60:.0f}" '
        f'viewBox="0 0 {width:.0f} {height + 60:.0f}" font-family="sans-serif" font-size="14">',
        '<rect width="100%" height="100%" fill="white"/>',
        f'<clipPath id="shown"><rect width="{width:.0f}" height="{height:.0f}"/></clipPath>',
        '<g clip-path="url(#shown)">',
        _line(np.array([[plan.task.robot.front, LEFT], [plan.task.robot.front, RIGHT]]), "#999", "6 4", 1.5),
        _text(plan.task.robot.front, LEFT, "the table begins", "#777", 6, -5),
        *_squares(plan),
        *_robot(plan),
        *_hands(plan),
        *_scale(),
        "</g>",
        *_legend(plan, height),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _pixel(x: float, y: float) -> tuple[float, float]:
    return SCALE * (LEFT - y), SCALE * (FAR - x)


def _squares(plan: RobotPlan) -> list[str]:
    """Every place that was tried with about the chosen height and turn; the best ones drawn last."""
    reach, chosen = plan.reach, plan.task.placement
    if reach is None:
        return []
    middle = _middle(plan)
    squares = []
    for placement, quality in reversed(list(zip(reach.placements, reach.quality, strict=True))):
        near = abs(placement.z - chosen.z) < 0.03 and abs(placement.yaw - chosen.yaw) < 0.25
        if near and placement.turning == chosen.turning:
            x, y = (placement.matrix @ middle)[:2]
            squares.append(_square(float(x), float(y), _colour(float(quality))))
    return squares


def _middle(plan: RobotPlan) -> np.ndarray:
    """The middle of both hands' paths in F, homogeneous, shape (4,)."""
    points = plan.task.hands.at(plan.via_times).reshape(-1, 3)
    return np.append((points.min(axis=0) + points.max(axis=0)) / 2, 1.0)


def _square(x: float, y: float, colour: str) -> str:
    left, top = _pixel(x + CELL / 2, y + CELL / 2)
    side = SCALE * CELL
    return f'<rect x="{left:.1f}" y="{top:.1f}" width="{side:.1f}" height="{side:.1f}" fill="{colour}" stroke="white"/>'


def _colour(quality: float) -> str:
    if quality < 0:
        return "#f3c6c0"
    return f"hsl({60 + 60 * min(1.0, quality / 0.5):.0f} 70% 62%)"


def _robot(plan: RobotPlan) -> list[str]:
    """Shoulders and what they span."""
    parts = []
    for arm in plan.task.robot.arms:
        chain = Chain.of(plan.task.robot, arm)
        x, y = _pixel(*chain.shoulder[:2])
        down = plan.task.placement.z - chain.shoulder[2]
        radius = SCALE * np.sqrt(max(0.0, chain.reach**2 - down**2))
        colour = COLOURS[arm.name]
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="9" fill="{colour}"/>')
        parts.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="none" stroke="{colour}" opacity="0.35"/>'
        )
    return parts


def _hands(plan: RobotPlan) -> list[str]:
    task, parts = plan.task, []
    points = task.hands.at(plan.via_times) @ task.placement.matrix[:3, :3].T + task.placement.matrix[:3, 3]
    for arm, path in zip(task.robot.arms, points, strict=True):
        parts.append(_line(path[:, :2], COLOURS[arm.name], "", 2.5))
        for point in path:
            x, y = _pixel(*point[:2])
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{COLOURS[arm.name]}"/>')
        parts.append(_text(path[0, 0], path[0, 1], f"{arm.name} grasps", "#333", 8, 16))
        parts.append(_text(path[-1, 0], path[-1, 1], "releases", "#333", 8, -8))
    return parts


def _scale() -> list[str]:
    bar = np.array([[NEAR + 0.03, RIGHT + 0.13], [NEAR + 0.03, RIGHT + 0.03]])
    return [_line(bar, "#333", "", 2), _text(NEAR + 0.03, RIGHT + 0.13, "10 cm", "#333", 24, -6)]


def _line(points: np.ndarray, colour: str, dashes: str, width: float) -> str:
    pixels = " ".join("{:.1f},{:.1f}".format(*_pixel(x, y)) for x, y in points)
    return (
        f'<polyline points="{pixels}" fill="none" stroke="{colour}" stroke-width="{width}" '
        f'stroke-dasharray="{dashes}"/>'
    )


def _text(x: float, y: float, words: str, colour: str, right: float, down: float) -> str:
    across, along = _pixel(x, y)
    return f'<text x="{across + right:.1f}" y="{along + down:.1f}" fill="{colour}">{words}</text>'


def _legend(plan: RobotPlan, height: float) -> list[str]:
    name, placement = escape(plan.task.robot.name), plan.task.placement
    squares = "squares: the middle of the fold; green well within reach, yellow just so, red not; "
    return [
        f'<text x="12" y="{height + 22:.0f}">{name}, from above, ahead is up; {placement}</text>',
        f'<text x="12" y="{height + 44:.0f}" fill="#555">{squares if plan.reach else ""}'
        "rings: what an arm spans at the table</text>",
    ]
