"""The test whether released cloth is at rest, by displacements, because its kinetic energy only shows jitter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Rest:
    """State of the test whether the cloth is at rest."""

    look_at: int = -1
    """Outer step of the next test; -1 while a hand holds or will hold the cloth, and when it is at rest."""
    before: np.ndarray | None = None
    """Positions at the previous test [m], shape (n, 3)."""
    reached: bool = False

    def looked(self, number: int, x: np.ndarray, wait: int, still: float) -> Rest:
        """Return the state after a test in outer step `number`, with the next one after `wait` outer steps.

        Cloth is at rest if its mean displacement since the previous test is below `still` [m].
        """
        if self.before is not None and np.linalg.norm(x - self.before, axis=1).mean() < still:
            return Rest(reached=True)
        return Rest(number + wait, x.copy())
