"""The test whether released cloth is at rest, by displacement, because kinetic energy only shows jitter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Rest:
    """The state of the test whether the cloth is at rest."""

    look_at: int = -1
    """Outer step of the next look; -1 while a hand holds the cloth, will take it again, or nothing is left to see."""
    before: np.ndarray | None = None
    """Positions at the last look [m], shape (n, 3)."""
    reached: bool = False
    """Whether the cloth rests."""

    def looked(self, number: int, x: np.ndarray, wait: int, still: float) -> Rest:
        """Return the state after a test.

        Args:
            number: The present outer step.
            x: Positions [m], shape (n, 3).
            wait: Outer steps between two looks.
            still: Mean displacement between two looks below which cloth rests [m].
        """
        if self.before is not None and np.linalg.norm(x - self.before, axis=1).mean() < still:
            return Rest(reached=True)
        return Rest(number + wait, x.copy())
