"""Observations of a scene. The user chooses them by their names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from gymnasium import spaces

from tatamu.base.errors import InputError
from tatamu.garments import Garment
from tatamu.policies.envs.cameras import Camera, Studio

Observation = np.ndarray | dict[str, np.ndarray]
OBSERVATIONS = ("vertices", "velocities", "key_points", "mask", "depth", "hands", *get_args(Camera))
"""All observations; those with the names of cameras are pictures."""
WIDEST = 1e3
"""Bound of coordinates [m] and velocities [m/s] in the observation space."""


@dataclass(frozen=True)
class View:
    """The state of a scene, from which observations are made."""

    positions: np.ndarray
    """Positions of the cloth [m], shape (n, 3)."""
    velocities: np.ndarray
    """Velocities of the cloth [m/s], shape (n, 3)."""
    hands: np.ndarray
    """Assumed positions of the hands [m], shape (k, 3)."""
    seen: np.ndarray
    """Actual positions of the hands [m], shape (k, 3)."""
    closed: np.ndarray
    """1 for hands that hold cloth, shape (k,)."""

    @classmethod
    def of_cloth(cls, positions: np.ndarray) -> View:
        """Return the state of cloth at rest without hands."""
        return cls(positions, np.zeros_like(positions), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


def key_points(garment: Garment) -> np.ndarray:
    """Return the vertices at which a named edge ends, in increasing order, shape (k,)."""
    ends = [end for path in garment.edges.values() for end in (path[0], path[-1])]
    return np.unique(np.array(ends, dtype=np.int64))


class Observer:
    """Makes the observations that the user has chosen."""

    def __init__(
        self, garment: Garment, start: np.ndarray, names: str | Sequence[str], hands: int, pixels: int = 96
    ) -> None:
        """Choose observations.

        Args:
            garment: The garment.
            start: Positions of the cloth before the fold [m], shape (n, 3).
            names: A name to get an array, or several to get arrays by name.
            hands: Number of hands that can be observed.
            pixels: Height and width of masks, depths and pictures.

        Raises:
            InputError: If a name is unknown or repeated, or `pixels` is out of range.
        """
        self.single = isinstance(names, str)
        self.names = (names,) if isinstance(names, str) else tuple(names)
        allowed = [name for name in OBSERVATIONS if hands or name != "hands"]
        if not self.names or len(set(self.names)) < len(self.names) or set(self.names) - set(allowed):
            raise InputError(
                f"observation: must be one or more of {', '.join(allowed)}, each at most once, given {names!r}"
            )
        if not 8 <= pixels <= 4096:
            raise InputError(f"pixels: must be from 8 to 4096, given {pixels}")
        self.studio = Studio(start, garment.faces, pixels)
        self._points = key_points(garment)
        self._shapes: dict[str, tuple[int, ...]] = {
            "vertices": (len(start), 3),
            "velocities": (len(start), 3),
            "key_points": (len(self._points), 3),
            "hands": (4 * hands,),
        }

    @property
    def space(self) -> spaces.Space[Any]:
        """The space of the observations, in the form of Gymnasium."""
        by_name: dict[str, spaces.Space[Any]] = {name: self._space(name) for name in self.names}
        return by_name[self.names[0]] if self.single else spaces.Dict(by_name)

    def observe(self, view: View) -> Observation:
        """Return the observations of the scene at one time."""
        by_name = {name: self._observe(name, view) for name in self.names}
        return by_name[self.names[0]] if self.single else by_name

    def _space(self, name: str) -> spaces.Box:
        square = (self.studio.pixels, self.studio.pixels)
        if name == "mask":
            return spaces.Box(0, 1, square, np.uint8)
        if name == "depth":
            return spaces.Box(-WIDEST, WIDEST, square, np.float32)
        if name in self._shapes:
            return spaces.Box(-WIDEST, WIDEST, self._shapes[name], np.float32)
        return spaces.Box(0, 255, (*square, 3), np.uint8)

    def _observe(self, name: str, view: View) -> np.ndarray:
        if name == "hands":
            return np.column_stack([view.hands, view.closed]).ravel().astype(np.float32)
        if name == "mask":
            return (self.studio.heights(view.positions) > 0.0).astype(np.uint8)
        if name == "depth":
            return self.studio.heights(view.positions)
        plain: Mapping[str, np.ndarray] = {
            "vertices": view.positions,
            "velocities": view.velocities,
            "key_points": view.positions[self._points],
        }
        if name in plain:
            return plain[name].astype(np.float32)
        camera: Any = name
        return self.studio.picture(camera, view.positions, view.seen)
