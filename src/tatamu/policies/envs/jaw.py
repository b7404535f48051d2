"""A hand with jaws: where it is assumed to be, where it is, and what it holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.simulation.native import HandTarget


@dataclass(frozen=True)
class HandsOptions:
    """Limits of the hands, and conditions of success."""

    speed: float = 0.6
    """Largest speed along each axis [m/s], that of planned folds (De Gusseme and wyffels 2022)."""
    reach: float = 0.012
    """Distance within which closing jaws grasp vertices [m]; at least 0.6 times the spacing."""
    beside: float = 0.25
    """Largest distance beside the flat cloth [m]."""
    highest: float = 0.6
    """Largest height [m]."""
    calm: float = 0.02
    """Mean speed above which the cloth does not rest [m/s]."""
    torn: float = -1.0
    """Reward of a step in which the cloth tears or flies away, which ends the episode."""


class Jaw:
    """A hand during an episode.

    Attributes:
        place: Assumed position [m], shape (3,).
        way: Length of its path so far [m].
        held: Vertices that it holds.
    """

    def __init__(self, place: np.ndarray, error: np.ndarray, lowest: float) -> None:
        """Start open.

        Args:
            place: Assumed position [m], shape (3,).
            error: Error of it [m], shape (3,).
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
        """Actual position [m], shape (3,). The table stops the hand."""
        there = self.place + self._error
        there[2] = max(there[2], self._lowest)
        return np.asarray(there)

    def lead(self, place: np.ndarray, close: bool, near: tuple[int, ...]) -> HandTarget | None:
        """Open or close, then move, and return the target of the hand's gripper; None if it holds nothing throughout.

        Args:
            place: Next assumed position [m], shape (3,).
            close: Whether to close.
            near: Vertices that closing jaws grasp.
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
