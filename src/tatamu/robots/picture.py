"""The reachability picture: the ground in front of the robot from above, as SVG.

Each square is a position for the middle of the fold, at the chosen height and orientation. The
colours mean:

- green: both arms can easily do the whole fold
- yellow: both arms can only just do the fold
- red: the arms cannot do the fold

The lines are the hands' paths at the chosen position.
"""

from __future__ import annotations

import colorsys

import numpy as np

from tatamu.robots.chain import Chain
from tatamu.robots.plan import RobotPlan
from tatamu.robots.pose import out_of
from tatamu.show.drawing import FROM_ABOVE, Drawing
from tatamu.show.shapes import Box, Dot

SCALE = 900.0
"""Scale of the picture: pixels per metre."""
LEFT = 0.55
RIGHT = -0.55
NEAR = -0.15
FAR = 0.85
"""Upper edge of the picture along x of the base B [m].

`NEAR` is the lower edge along x. `LEFT` and `RIGHT` are the edges along y. In the picture, x points up and y points to
the left, as seen from behind the robot.
"""
CELL = 0.034
"""Side length of a square of the reachability picture [m]."""
COLOURS = {"larm": "left", "rarm": "right"}


def reach_svg(plan: RobotPlan) -> str:
    """Return the picture of a plan as text."""
    name = plan.task.robot.name
    squares = "squares: the middle of the fold; green well within reach, yellow just so, red not; "
    caption = (
        f"{name}, from above, ahead is up; {plan.task.placement}",
        f"{squares if plan.reach else ''}rings: what an arm spans at the table",
    )
    drawing = Drawing(np.array([NEAR, RIGHT]), np.array([FAR, LEFT]), SCALE, FROM_ABOVE, caption=caption)
    front = plan.task.robot.front
    _draw_squares(drawing, plan)
    drawing.line([[front, LEFT], [front, RIGHT]], "muted", 1.5, dash=6.0)
    drawing.label([front + 0.012, LEFT - 0.065], "the table begins", "muted")
    _draw_robot(drawing, plan)
    _draw_hands(drawing, plan)
    drawing.ruler([NEAR + 0.03, RIGHT + 0.03], "ink")
    return drawing.svg() + "\n"


def _draw_squares(drawing: Drawing, plan: RobotPlan) -> None:
    """Draw a square for every position that was tried with nearly the chosen height and orientation."""
    reach = plan.reach
    chosen = plan.task.placement
    if reach is None:
        return
    points = plan.task.hands.at(plan.task.hands.times).reshape(-1, 3)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2  # of both hands' paths
    for placement, _, quality, _ in reversed(reach):
        near = abs(placement.z - chosen.z) < 0.03 and abs(placement.yaw - chosen.yaw) < 0.25
        if near and placement.turning == chosen.turning:
            centre = (placement.matrix @ np.append(middle, 1.0))[:2]
            drawing.add(Box(centre - CELL / 2, centre + CELL / 2, _colour(quality), "card"))


def _colour(quality: float) -> str:
    """Return a colour from yellow to green by the quality; red if the position is out of reach."""
    if quality < 0:
        return "#f3c6c0"
    hue = (60 + 60 * min(1.0, quality / 0.5)) / 360
    return "#" + "".join(f"{round(255 * part):02x}" for part in colorsys.hls_to_rgb(hue, 0.62, 0.70))


def _draw_robot(drawing: Drawing, plan: RobotPlan) -> None:
    """Draw the shoulders of the robot and the reach of its arms."""
    turn = np.linspace(0.0, 2 * np.pi, 97)
    around = np.column_stack([np.cos(turn), np.sin(turn)])
    for arm in plan.task.robot.folding:
        chain = Chain.of(plan.task.robot, arm)
        shoulder = chain.shoulder[:2]
        down = plan.task.placement.z - chain.shoulder[2]
        radius = np.sqrt(max(0.0, chain.reach**2 - down**2))
        drawing.add(Dot(shoulder, COLOURS[arm.name], 9.0))
        drawing.line(shoulder + radius * around, COLOURS[arm.name], 1.0, opacity=0.5)


def _draw_hands(drawing: Drawing, plan: RobotPlan) -> None:
    task = plan.task
    points = out_of(task.placement.matrix, task.hands.at(plan.task.hands.times))
    for arm, path in zip(task.robot.folding, points, strict=True):
        colour = COLOURS[arm.name]
        drawing.line(path[:, :2], colour, 2.5)
        drawing.add(*(Dot(point, colour, 3.0) for point in path[:, :2]))
        drawing.label(path[0, :2], f"{arm.name} grasps", "ink", (-0.7, -0.7))
        drawing.label(path[-1, :2], "releases", "ink", (0.7, -0.7))
