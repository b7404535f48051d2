"""Collects the data for the replay of a learned fold."""

from __future__ import annotations

from typing import Any

from tatamu.show.replay import HAND_COLOURS, HandTrack, replay_data
from tatamu.study.result import Result


def replay(fold: Result, largest: float) -> dict[str, Any]:
    """Return the data for the replay of a learned fold.

    Colours show the distance of each vertex from its target, up to `largest` [m].
    """
    return replay_data(fold.rollout, fold.scene, hands(fold), largest)


def hands(fold: Result) -> list[HandTrack]:
    """Return the motions of the hands of a learned fold."""
    timing = fold.description.timing
    hold = (timing.closes, timing.opens) if timing else (0.0, None)
    return [HandTrack(colour, fold.hand(arm), [hold]) for colour, arm in zip(HAND_COLOURS, fold.arms, strict=False)]
