"""The replay of a learned fold."""

from __future__ import annotations

from typing import Any

from tatamu.presentation.replay import HAND_COLOURS, HandTrack, replay_data
from tatamu.results import LearnedFold


def replay(fold: LearnedFold, largest: float) -> dict[str, Any]:
    """The data of the viewer; `largest` is the end of the scale of e_i [m]."""
    return replay_data(fold.rollout, fold.scene, hands(fold), largest)


def hands(fold: LearnedFold) -> list[HandTrack]:
    """The hands of a learned fold."""
    timing = fold.manipulation.timing
    hold = (timing.closes, timing.opens) if timing else (0.0, None)
    return [
        HandTrack(colour, fold.hand(arm), [hold])
        for colour, arm in zip(HAND_COLOURS, fold.manipulation.arms, strict=False)
    ]
