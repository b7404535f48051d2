"""A fold: a line on the flat garment, the side that moves, and the shape that is wanted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.errors import InputError
from tatamu.folding.crease import crease
from tatamu.garments import Garment
from tatamu.topology import Topology

HAND_CLEARANCE = 0.06
"""Grasps of the two hands stay at least this far apart [m]; so hands never cross or touch."""


@dataclass(frozen=True)
class Fold:
    """A fold of one garment across a straight line."""

    garment: Garment
    line: np.ndarray
    """Two points of the fold line [m], shape (2, 2)."""
    normal: np.ndarray
    """Unit vector across the line, from the moving side to the side that stays, shape (2,)."""
    target: np.ndarray
    """The wanted shape S_t [m], shape (n, 3)."""
    translation: np.ndarray
    """From a grasp P0 to its release P3 [m], shape (3,)."""
    left: np.ndarray
    """Grasp candidates of the left hand, from the corner inwards, shape (M,)."""
    right: np.ndarray
    """Grasp candidates of the right hand, from the corner inwards, shape (M,)."""

    @property
    def candidates(self) -> int:
        """M: the number of grasps that each hand may choose from."""
        return len(self.left)

    @property
    def span(self) -> float:
        """Horizontal way from grasp to release [m]."""
        return float(np.hypot(*self.translation[:2]))

    def still(self) -> np.ndarray:
        """Vertices that a perfect fold does not move, shape (n,)."""
        return np.linalg.norm(self.target - self.garment.vertices, axis=1) < 1e-6


def half_fold(garment: Garment) -> Fold:
    """Fold the garment in half across its length: the side x < 0 comes to lie on the side x > 0.

    The target is flush: every point of the moving side lies a thickness above the point it mirrors, and near the line
    the cloth follows the crease of least energy (see `crease`). P3 = P0 + (length, 0, thickness).
    """
    vertices, material = garment.vertices, garment.material
    profile = crease(material.bending_length, material.thickness)
    if profile.arc[-1] > 0.5 * garment.size[1]:
        raise InputError(
            f"fold: a crease of this material takes {profile.arc[-1]:.3f} m on either side, but half the garment "
            f"is {0.5 * garment.size[1]:.3f} m; give a longer garment or a limper material"
        )
    x, z = profile.place(vertices[:, 0])
    half_width = 0.5 * garment.size[0]
    left, right = _edge_candidates(garment)
    return Fold(
        garment=garment,
        line=np.array([[0.0, -half_width], [0.0, half_width]]),
        normal=np.array([1.0, 0.0]),
        target=np.column_stack([x, vertices[:, 1], z]),
        translation=np.array([garment.size[1], 0.0, material.thickness]),
        left=left,
        right=right,
    )


def _edge_candidates(garment: Garment) -> tuple[np.ndarray, np.ndarray]:
    """Border vertices along the moving edge, each hand's on its own side, from the corner inwards."""
    border = np.unique(Topology(garment.faces).border)
    x, y = garment.vertices[border, 0], garment.vertices[border, 1]
    edge = border[x < x.min() + 0.25 * garment.spacing]
    y = garment.vertices[edge, 1]
    clearance = max(HAND_CLEARANCE, 2.7 * garment.spacing)  # coarse meshes: the pinches share no vertex
    left, right = edge[y >= clearance / 2], edge[y <= -clearance / 2]
    if not (len(left) and len(right)):
        raise InputError(f"size: two hands {clearance:g} m apart do not fit on an edge of {garment.size[0]:g} m")
    count = min(len(left), len(right))
    order_left = left[np.argsort(-garment.vertices[left, 1])]
    order_right = right[np.argsort(garment.vertices[right, 1])]
    return order_left[:count], order_right[:count]


FOLDS = {"half": half_fold}
"""Name of each fold and the function that makes it from a garment."""


def make_fold(name: str, garment: Garment) -> Fold:
    """The fold of that name.

    Raises:
        InputError: There is no such fold, or the garment cannot be folded so.
    """
    if name not in FOLDS:
        raise InputError(f"fold: must be one of {', '.join(FOLDS)}, given {name!r}")
    return FOLDS[name](garment)
