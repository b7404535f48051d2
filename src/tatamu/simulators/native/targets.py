"""Targets that a controller gives the grippers of a running scene, with their checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from tatamu.errors import InputError

Place = tuple[float, ...]
"""x, y, z [m] in plain numbers: of three, these are handled in less time than arrays."""
NOWHERE: Place = (0.0, 0.0, 0.0)
"""The displacement of a gripper that is open, or has just closed [m]."""


@dataclass(frozen=True)
class HandTarget:
    """The target of a gripper in one call of `Simulation.advance`."""

    displacement: Sequence[float] | np.ndarray | None = None
    """Displacement from where it closed [m], shape (3,), reached at the end of the call; None if it stays."""
    closed: bool | None = None
    """Whether it closes or opens at the start of the call; None if it does neither."""
    vertices: Sequence[int] | np.ndarray | None = None
    """Vertices on which it closes; None for those of the scene."""

    def place(self, name: str) -> Place | None:
        """Return the displacement in plain numbers [m]; None if there is none.

        Raises:
            InputError: If it is not three finite numbers; the message begins with `name`.
        """
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
        """The vertices that the gripper holds from the start of the call on; None if it is open.

        Args:
            name: Name of this target in messages.
            before: The vertices that it holds before; None if it is open.
            usual: The vertices on which it closes if this target names none.
            count: Number of vertices of the cloth.

        Raises:
            InputError: If the vertices are none of the cloth, or others than the gripper holds.
        """
        closed = before is not None if self.closed is None else bool(self.closed)
        if not closed:
            if self.displacement is not None or self.vertices is not None:
                wrong = "vertices" if self.displacement is None else "displacement"
                raise InputError(f"{name}.{wrong}: must be left out while the gripper is open; close it first")
            return None
        if self.vertices is None:
            return usual if before is None else before
        vertices = _indices(self.vertices, name, count)
        if before is not None and set(vertices) != set(before):
            raise InputError(f"{name}.vertices: must be those that the gripper holds; open it before it takes others")
        return before or vertices


def _indices(given: Sequence[int] | np.ndarray, name: str, count: int) -> tuple[int, ...]:
    array = np.asarray(given)
    whole = array.ndim == 1 and len(array) > 0 and np.issubdtype(array.dtype, np.integer)
    if not whole or len(np.unique(array)) < len(array) or array.min() < 0 or array.max() >= count:
        raise InputError(f"{name}.vertices: must be different numbers of vertices below {count}, given {given}")
    return tuple(int(vertex) for vertex in array)
