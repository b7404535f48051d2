"""Targets that a controller gives to the grippers of a running scene, and their checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from tatamu.base.errors import InputError

Place = tuple[float, ...]
"""Coordinates x, y and z [m] as plain numbers, which are faster than arrays."""
NOWHERE: Place = (0.0, 0.0, 0.0)
"""Displacement of a gripper that is open or has just closed [m]."""


@dataclass(frozen=True)
class HandTarget:
    """The target of one gripper in one call of `Simulation.advance`."""

    displacement: Sequence[float] | np.ndarray | None = None
    """Displacement since the gripper closed, at the end of the call [m], shape (3,); None if it does not move."""
    closed: bool | None = None
    """True to close the gripper at the start of the call, False to open it, None to leave it unchanged."""
    vertices: Sequence[int] | np.ndarray | None = None
    """Vertices that the gripper grasps if it closes; None for the vertices that the scene gives."""

    def place(self, name: str) -> Place | None:
        """Return the displacement as plain numbers [m], None if there is none, or raise InputError."""
        if self.displacement is None:
            return None
        try:
            place = tuple(map(float, self.displacement))
        except (TypeError, ValueError):
            place = ()
        if len(place) != 3 or not isfinite(sum(place)):
            raise InputError(f"{name}.displacement: must be three finite numbers [m], given {self.displacement}")
        return place

    def held(
        self, name: str, before: tuple[int, ...] | None, usual: tuple[int, ...], count: int
    ) -> tuple[int, ...] | None:
        """Return the vertices that the gripper then holds, None if it is open, or raise InputError.

        It held `before` (None if it was open), grasps `usual` by default, and the cloth has `count` vertices.
        """
        closed = before is not None if self.closed is None else bool(self.closed)
        if not closed:
            if self.displacement is not None or self.vertices is not None:
                wrong = "vertices" if self.displacement is None else "displacement"
                raise InputError(f"{name}.{wrong}: must be left out while the gripper is open; close the gripper first")
            return None
        if self.vertices is None:
            return usual if before is None else before
        vertices = _indices(self.vertices, name, count)
        if before is not None and set(vertices) != set(before):
            raise InputError(
                f"{name}.vertices: must be those that the gripper holds; open the gripper before it grasps others"
            )
        return before or vertices


def _indices(given: Sequence[int] | np.ndarray, name: str, count: int) -> tuple[int, ...]:
    array = np.asarray(given)
    whole = array.ndim == 1 and len(array) > 0 and np.issubdtype(array.dtype, np.integer)
    if not whole or len(np.unique(array)) < len(array) or array.min() < 0 or array.max() >= count:
        raise InputError(f"{name}.vertices: must be different vertex numbers below {count}, given {given}")
    return tuple(int(vertex) for vertex in array)
