"""The time of a scene in segments, in which no gripper opens or closes and all hands move on straight lines."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tatamu.simulation.scene import Scene


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


def segments(scene: Scene, longest: float) -> list[Segment]:
    """Divide the time of a scene at each frame, opening and closing, and into segments of at most `longest` [s]."""
    frames = np.arange(scene.frames) / scene.frame_rate
    events = [time for gripper in scene.grippers for time in (gripper.closes, gripper.opens) if time is not None]
    instants = [(float(time), True) for time in frames]
    for event in sorted(set(events)):
        if 0.0 < event < frames[-1] and np.abs(frames - event).min() > 1e-7:  # otherwise the times are equal
            instants.append((event, False))
    found = []
    for (start, _), (end, frame) in pairwise(sorted(instants)):
        middle = 0.5 * (start + end)
        held = tuple(each.closes <= middle and (each.opens is None or middle < each.opens) for each in scene.grippers)
        pieces = max(1, int(np.ceil((end - start) / longest - 1e-6)))
        bounds = [start + (end - start) * k / pieces for k in range(pieces)] + [end]
        found += [Segment(a, b, frame and b == end, held) for a, b in pairwise(bounds)]
    return found
