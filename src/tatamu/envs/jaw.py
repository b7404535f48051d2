"""A hand with a jaw: its assumed and its actual place, and the vertices that it holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.simulators.native import HandTarget


@dataclass(frozen=True)
class HandsOptions:
    """Limits of the hands, and the conditions of success."""

    speed: float = 0.6
    """Highest speed along each axis [m/s], that of a manipulation (De Gusseme and wyffels 2022)."""
    reach: float = 0.012
    """Distance within which a jaw that closes grasps vertices [m]; at least 0.6 spacings of the mesh."""
    beside: float = 0.25
    """Hands stay over the table within this margin of the flat cloth [m]."""
    highest: float = 0.6
    """Largest height of hands [m]."""
    calm: float = 0.02
    """Mean speed of the cloth below which a fold counts [m/s]."""
    torn: float = -1.0
    """Reward of a step in which the cloth is torn or flies away, which ends the episode."""


class Jaw:
    """A hand in the course of an episode.

    Attributes:
        place: Its assumed place [m], shape (3,).
        way: Length of its path so far [m].
        held: The vertices that it holds; none if it is open.
    """

    def __init__(self, place: np.ndarray, error: np.ndarray, lowest: float) -> None:
        """Begin with an open jaw.

        Args:
            place: Its assumed place [m], shape (3,).
            error: Error of that place [m], shape (3,).
            lowest: Height at which it meets the table [m].
        """
        self.place = np.array(place)
        self.way = 0.0
        self.held: tuple[int, ...] = ()
        self._closed_at = self.place
        self._error = error
        self._lowest = lowest

    @property
    def actual(self) -> np.ndarray:
        """Actual place [m], shape (3,); a hand that is commanded below the table stops at the table."""
        there = self.place + self._error
        there[2] = max(there[2], self._lowest)
        return np.asarray(there)

    def lead(self, place: np.ndarray, close: bool, near: tuple[int, ...]) -> HandTarget | None:
        """Open or close the jaw, then move; return the target for the hand's gripper, None if it does nothing.

        Args:
            place: Its next assumed place [m], shape (3,).
            close: Whether the jaw is to be closed.
            near: Vertices that it grasps if it closes now.
        """
        before = self.actual
        self.way += float(np.linalg.norm(place - self.place))
        self.place = place
        if self.held and not close:
            self.held = ()
            return HandTarget(closed=False)
        if self.held:
            return HandTarget(self.actual - self._closed_at)
        if not close or not near:
            return None
        self.held = near
        self._closed_at = before
        return HandTarget(self.actual - before, True, near)
