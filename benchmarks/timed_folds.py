"""The folds that benchmarks time: a towel and a T-shirt, and whether a rollout ended folded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.folding.fold import Fold as HalfFold
from tatamu.folding.fold import make_fold
from tatamu.folding.manipulation import polyline_manipulation
from tatamu.folding.trial_scene import scene_of
from tatamu.garments import make_garment
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.presets import load_preset
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene

SIZE = (0.34, 0.80)
"""Width and length of the towel [m]."""
CLOTH = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4, thickness=0.001)
"""A fabric with a bending length of 3.7 cm."""
JERSEY = Material(
    areal_density=0.15, stretch_stiffness=200.0, bending_rigidity=0.15 * GRAVITY * 0.02**3, thickness=0.001
)
"""A limp fabric: bending length 2 cm."""
FABRICS = {
    "stiff, bending length 3.7 cm": CLOTH,
    "terry, the default towel": load_preset("terry").material,
    "jersey, bending length 2 cm": JERSEY,
}
FOLDED = 0.02
"""Mean distance of the vertices to their places in a half fold [m]: a rollout beyond it did not fold, and its time
counts for nothing. De Gusseme and wyffels 2022 call 20 mm a failed fold."""


@dataclass(frozen=True)
class Fold:
    """A scene, and the places where its vertices should end."""

    name: str
    scene: Scene
    target: np.ndarray
    """Places where the vertices should end [m], shape (n, 3)."""

    def distance(self, rollout: Rollout) -> float:
        """Mean distance of the vertices to their target at the end [m]."""
        return float(np.linalg.norm(rollout.positions[-1] - self.target, axis=1).mean())


def towel(spacing: float, material: Material = CLOTH, height: float = 0.5) -> Fold:
    """A towel folded in half by two hands that rise to `height` times its length over the fold line."""
    fold = make_fold("half", make_garment("towel", SIZE, material, spacing))
    return Fold("towel", _scene(fold, height), fold.target)


def shirt(spacing: float) -> Fold:
    """The T-shirt, two sewn layers of jersey, folded in half by two hands that hold both layers."""
    fold = make_fold("half", make_garment("tshirt", None, load_preset("jersey").material, spacing))
    return Fold("T-shirt", _scene(fold, 0.5), fold.target)


def _scene(fold: HalfFold, height: float) -> Scene:
    """Straight up to a point above the fold line, and straight down, at the speed of tatamu's own trials.

    Hands hold the edge alone: a second row within the pinch, which only fine meshes have, would hold its slope too.
    """
    grasps = int(fold.left[0]), int(fold.right[0])
    ways = tuple(_way(fold.translation(vertex), height * fold.span_of(vertex)) for vertex in grasps)
    scene = scene_of(fold, polyline_manipulation(fold, grasps, ways))
    x = fold.start[:, 0]
    hands = [
        g.model_copy(update={"vertices": [v for v in g.vertices if abs(x[v] - x[grasp]) < 1e-9]})
        for g, grasp in zip(scene.grippers, grasps, strict=True)
    ]
    return scene.model_copy(update={"grippers": hands})


def _way(translation: np.ndarray, top: float) -> np.ndarray:
    return np.stack([np.zeros(3), 0.5 * translation + [0.0, 0.0, top], translation])
