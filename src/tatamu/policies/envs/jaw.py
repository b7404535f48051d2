"""A hand with a jaw: its assumed and its actual position, and the vertices that it holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.simulation.native import HandTarget


@dataclass(frozen=True)
class HandsOptions:
    """Limits of the hands' motion, and the conditions for a successful fold."""

    speed: float = 0.6
    """Largest speed of a hand along each axis [m/s].

    Hands in planned folds have the same largest speed, which comes from De Gusseme and wyffels (2022).
    """
    reach: float = 0.012
    """Reach of a closing jaw [m]. The jaw grasps the vertices within this distance.

    If the reach is smaller than 0.6 times the spacing of the mesh, 0.6 times this spacing is used instead.
    """
    beside: float = 0.25
    """Largest horizontal distance of a hand from the area of the flat cloth [m]."""
    highest: float = 0.6
    """Largest height of the hands [m]."""
    calm: float = 0.02
    """Limit for the mean speed of the cloth [m/s]. While the cloth is faster, a fold does not count as successful."""
    torn: float = -1.0
    """Reward of a step whose simulation fails because the cloth tears or flies away. The step ends the episode."""


class Jaw:
    """A hand with a jaw during an episode.

    Attributes:
        place: Assumed position of the hand [m], shape (3,).
        way: Length of the hand's path so far [m].
        held: Vertices that the jaw holds; empty if the jaw is open or holds nothing.
    """

    def __init__(self, place: np.ndarray, error: np.ndarray, lowest: float) -> None:
        """Start with an open jaw.

        Args:
            place: Assumed position of the hand [m], shape (3,).
            error: Error of the assumed position [m], shape (3,).
            lowest: Height at which the hand touches the table [m].
        """
        self.place = np.array(place)
        self.way = 0.0
        self.held: tuple[int, ...] = ()
        self._closed_at = self.place
        self._error = error
        self._lowest = lowest

    @property
    def actual(self) -> np.ndarray:
        """Actual position of the hand [m], shape (3,).

        A hand that is commanded to move below the table stops at the table top.
        """
        there = self.place + self._error
        there[2] = max(there[2], self._lowest)
        return np.asarray(there)

    def lead(self, place: np.ndarray, close: bool, near: tuple[int, ...]) -> HandTarget | None:
        """Open or close the jaw, then move the hand.

        Return the next target of the hand's gripper in the simulation. Return None if the jaw holds no cloth, neither
        before nor after.

        Args:
            place: Next assumed position of the hand [m], shape (3,).
            close: Whether the jaw should be closed.
            near: Vertices that the jaw grasps if it closes now.
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
