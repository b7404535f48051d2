"""The time of a scene in segments: within a segment no gripper opens or closes, and hands move on straight lines."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tatamu.scene import Gripper, Scene

SAME = 1e-7
"""Largest difference of instants that are equal [s]."""


@dataclass(frozen=True)
class Segment:
    """A stretch of time in which the same grippers hold."""

    start: float
    """[s]"""
    end: float
    """[s]"""
    frame: bool
    """Whether a frame of the rollout lies at its end."""
    held: tuple[bool, ...]
    """Whether each gripper holds during the segment."""

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.end - self.start


def holds(gripper: Gripper, start: float, end: float) -> bool:
    """Whether the gripper holds from `start` to `end`, which lie on the same side of its closing and opening."""
    middle = 0.5 * (start + end)
    return gripper.closes <= middle and (gripper.opens is None or middle < gripper.opens)


def segments(scene: Scene, longest: float) -> list[Segment]:
    """Cut a scene's time at its frames and at each closing and opening, then into pieces of at most `longest` [s]."""
    frames = np.arange(scene.frames) / scene.frame_rate
    events = [time for gripper in scene.grippers for time in (gripper.closes, gripper.opens) if time is not None]
    instants = [(float(time), True) for time in frames]
    for event in sorted(set(events)):
        if 0.0 < event < frames[-1] and np.abs(frames - event).min() > SAME:
            instants.append((event, False))
    instants = sorted(instants)
    return [
        piece for (start, _), (end, frame) in pairwise(instants) for piece in _cut(scene, start, end, frame, longest)
    ]


def _cut(scene: Scene, start: float, end: float, frame: bool, longest: float) -> list[Segment]:
    held = tuple(holds(gripper, start, end) for gripper in scene.grippers)
    pieces = max(1, int(np.ceil((end - start) / longest - 1e-6)))
    bounds = [start + (end - start) * k / pieces for k in range(pieces)] + [end]
    return [Segment(a, b, frame and number == pieces - 1, held) for number, (a, b) in enumerate(pairwise(bounds))]
