"""The test whether released cloth is at rest.

The test uses displacements and not kinetic energy, because the kinetic energy of cloth at rest only shows jitter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Rest:
    """State of the test that decides whether the cloth is at rest."""

    look_at: int = -1
    """Number of the outer step of the next test; -1 if no test is necessary.

    No test is necessary while a hand holds the cloth or will hold it later, and when the cloth is at rest."""
    before: np.ndarray | None = None
    """Positions at the previous test [m], shape (n, 3)."""
    reached: bool = False
    """Whether the cloth is at rest."""

    def looked(self, number: int, x: np.ndarray, wait: int, still: float) -> Rest:
        """Return the state after a test.

        Args:
            number: Number of the present outer step.
            x: Positions [m], shape (n, 3).
            wait: Number of outer steps between two tests.
            still: Limit for the mean displacement between two tests [m]. If the displacement is smaller, the cloth is
                at rest.
        """
        if self.before is not None and np.linalg.norm(x - self.before, axis=1).mean() < still:
            return Rest(reached=True)
        return Rest(number + wait, x.copy())
