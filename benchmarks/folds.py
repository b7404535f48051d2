"""The folds that benchmarks time: a towel and a sheet of two sewn layers, and whether a rollout ended folded."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tatamu.folding.fold import Fold as HalfFold
from tatamu.folding.fold import half_fold
from tatamu.folding.manipulation import Manipulation, scene_of
from tatamu.garments.fabrics import TERRY
from tatamu.garments.garment import Garment
from tatamu.garments.towel import staggered_rectangle
from tatamu.material import GRAVITY, Material
from tatamu.rollout import Rollout
from tatamu.scene import Scene
from tatamu.validation.meshes import staggered
from tatamu.validation.scenes import sewn

SIZE = (0.34, 0.80)
"""Width and length of the towel [m]."""
SHIRT = (0.36, 0.60)
"""Width and length of the sewn sheet [m]."""
CLOTH = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4, thickness=0.001)
"""Bending length 3.7 cm: all four simulators hold its loop open on a 2 cm mesh, or nearly."""
JERSEY = Material(
    areal_density=0.15, stretch_stiffness=200.0, bending_rigidity=0.15 * GRAVITY * 0.02**3, thickness=0.001
)
"""A limp fabric: bending length 2 cm."""
FABRICS = {"terry, the default towel": TERRY, "jersey, bending length 2 cm": JERSEY}
FOLDED = 0.02
"""Mean distance of the vertices to their places in a half fold [m]: a rollout beyond it did not fold, and its time
counts for nothing. De Gusseme and wyffels 2022 call 20 mm a failed fold."""


@dataclass(frozen=True)
class Fold:
    """A scene, and where its vertices should end."""

    name: str
    scene: Scene
    target: np.ndarray
    """[m], shape (n, 3)."""

    def distance(self, rollout: Rollout) -> float:
        """Mean distance of the vertices to their target at the end [m]."""
        return float(np.linalg.norm(rollout.positions[-1] - self.target, axis=1).mean())


def towel(spacing: float, material: Material = CLOTH, height: float = 0.5) -> Fold:
    """A towel folded in half by two hands that rise to `height` times its length over the fold line."""
    vertices, faces = staggered_rectangle(*SIZE, spacing)
    vertices[:, 2] = 0.5 * material.thickness
    fold = half_fold(Garment("towel", SIZE, spacing, vertices, faces, material))
    return Fold("towel", _scene(fold, height), fold.target)


def shirt(spacing: float, material: Material = JERSEY) -> Fold:
    """Two layers sewn along both sides, like the body of a T-shirt, folded in half; hands hold both layers."""
    (width, length), t = SHIRT, material.thickness
    vertices, faces, seams = sewn(staggered(length, width, spacing), t)
    vertices += [-0.5 * length, -0.5 * width, 0.5 * t]
    fold = half_fold(Garment("shirt", SHIRT, spacing, vertices, faces, material, seams))
    fold = replace(fold, translation=np.array([length, 0.0, 2.0 * t]))  # onto two layers
    folded = vertices * [-1.0, 1.0, -1.0] + [0.0, 0.0, 4.0 * t]
    return Fold("sewn sheet", _scene(fold, 0.5), np.where(vertices[:, :1] < 0.0, folded, vertices))


def _scene(fold: HalfFold, height: float) -> Scene:
    """Straight up to a point above the fold line, and straight down, at the speed of tatamu's own trials."""
    top = 0.5 * fold.translation + [0.0, 0.0, height * fold.span]
    way = np.stack([np.zeros(3), top, fold.translation])
    return scene_of(fold, Manipulation((int(fold.left[0]), int(fold.right[0])), way, None))
