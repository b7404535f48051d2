"""Commands to the grippers, and the times at which a program that plays a plan can stop.

    approach ─▶ close ─▶ fold ─▶ open ─▶ leave

The robot is at rest before the jaws close, and again before the jaws open. At these times, a program can wait until a
person lets it continue.
"""

from __future__ import annotations

from tatamu.robots.model import Arm
from tatamu.robots.motion import Motion
from tatamu.robots.planfile import GripperCommand, Segment

SHUT = 0.0
"""Width to which a jaw is commanded when it grips cloth [m].

The cloth stops the fingers at a larger width.
"""


def segments(motion: Motion, hover: float) -> tuple[Segment, ...]:
    """Return the parts of the robot's motion. A program that plays the motion can stop between two parts."""
    closing, opening = motion.part("close"), motion.part("open")
    end = max(part.start + part.timed.duration for part in motion.parts)
    spans = (
        ("approach", 0.0, closing.start, "close"),
        ("fold", closing.start + closing.timed.duration, opening.start, "open"),
        ("leave", opening.start + opening.timed.duration, end, ""),
    )
    return tuple(
        Segment.model_validate(
            {
                "name": name,
                "start": round(begins, 6),
                "duration": round(ends - begins, 6),
                "then": "" if hover else then,
            }
        )
        for name, begins, ends, then in spans
    )


def gripper_commands(motion: Motion, arms: tuple[Arm, ...], hover: float) -> tuple[GripperCommand, ...]:
    """Return the commands to the grippers in the order of time.

    The jaws open at the start, close at the event `close` and open again at the event `open`.
    """
    widths = [("lead", False)] if hover else [("lead", False), ("close", True), ("open", False)]
    return tuple(
        GripperCommand.model_validate(
            {
                "time": round(motion.part(stage).start, 6),
                "arm": arm.name,
                "width": SHUT if closed else arm.jaw.opening,
                "force": arm.jaw.force,
                "duration": round(motion.part(stage).timed.duration, 6),
            }
        )
        for stage, closed in widths
        for arm in arms
    )
