"""The time of a scene in segments, in which no gripper opens or closes and all hands move on straight lines."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tatamu.simulation.scene import Gripper, Scene

SAME = 1e-7
"""Maximum difference of equal times [s]."""


@dataclass(frozen=True)
class Segment:
    """An interval from `start` to `end` [s]."""

    start: float
    end: float
    frame: bool
    """Whether the segment ends at a frame of the rollout."""
    held: tuple[bool, ...]
    """Whether each gripper is closed during the segment."""

    @property
    def duration(self) -> float:
        return self.end - self.start


def holds(gripper: Gripper, start: float, end: float) -> bool:
    """Return whether a gripper is closed from `start` to `end`, between which it must not open or close."""
    middle = 0.5 * (start + end)
    return gripper.closes <= middle and (gripper.opens is None or middle < gripper.opens)


def segments(scene: Scene, longest: float) -> list[Segment]:
    """Divide the time of a scene at each frame, opening and closing, and into segments of at most `longest` [s]."""
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
