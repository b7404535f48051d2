"""Makes a T-shirt: a front and a back, sewn along sides, sleeves and shoulders, open at neck, sleeves and hem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tatamu.garments.garment import Garment
from tatamu.garments.outline import Outline, mirrored
from tatamu.garments.sewing import front_and_back
from tatamu.simulation.material import Material
from tatamu.simulation.presets import load_preset

SIZE = (0.54, 0.46)
"""Width over both sleeves and length from shoulder to hem [m] for a child of four years, by the chart of garments laid
flat of the 23rd New Zealand Scout Jamboree: in the row "youth 4", half the chest is 32 cm and the length 46 cm. In
men's size M, they are 52 and 70 cm, so a T-shirt with sleeves in proportion has the size 0.88x0.70."""
OPENINGS = ("hem", "right_sleeve", "left_sleeve", "back_neck")
CORNERS = {
    "hem": (0.0, 0.160),
    "underarm": (0.310, 0.160),
    "sleeve": ((0.262, 0.228), (0.352, 0.270)),
    "shoulder": (0.432, 0.132),
    "neck": (0.460, 0.068),
}
"""Corners of the left half [m], x from the hem and y from the middle. The sleeve (16 cm along its top, 10 cm at its
hem) and the neck (14 cm) are assumed, the rest is from the chart."""
NECK_DEPTH = {"front": 0.055, "back": 0.015}
"""Assumed depths of the necklines below the shoulder [m]."""


def tshirt(
    size: tuple[float, float] | None = None, material: Material | None = None, spacing: float | None = None
) -> Garment:
    """Make a T-shirt of a width (over the sleeves, y) and length (x) [m], with the hem at x < 0."""
    material = material or load_preset("usual-tshirt").material
    shirt = front_and_back("tshirt", pattern().fitted(size or SIZE), OPENINGS, material, spacing)
    return replace(shirt, fibre=_fibre(shirt))


def _fibre(shirt: Garment) -> np.ndarray:
    """Return the direction of the wales, the lengthwise columns of a knit, in each triangle, shape (m, 3).

    It is along the sleeve in the sleeves, and along x elsewhere.
    """
    plan = shirt.unstrained[:, :2]
    scale = np.ptp(plan, axis=0) / SIZE[::-1]
    corners = {name: np.array(CORNERS[name]) * scale + [plan[:, 0].min(), 0.0] for name in ("underarm", "shoulder")}
    armhole = corners["shoulder"] - corners["underarm"]
    end = np.array(CORNERS["sleeve"]).mean(axis=0) * scale + [plan[:, 0].min(), 0.0]
    along = end - 0.5 * (corners["shoulder"] + corners["underarm"])
    middle = plan[shirt.faces].mean(axis=1)
    beyond = np.column_stack([middle[:, 0], np.abs(middle[:, 1])]) - corners["underarm"]
    in_sleeve = armhole[0] * beyond[:, 1] - armhole[1] * beyond[:, 0] > 0.0
    fibre = np.tile([1.0, 0.0, 0.0], (len(middle), 1))
    sides = np.sign(middle[in_sleeve, 1])
    fibre[in_sleeve, :2] = np.column_stack([np.full(len(sides), along[0]), sides * along[1]]) / np.linalg.norm(along)
    return fibre


def pattern() -> Outline:
    """Return the outline of the back, with a line for the neckline of the front."""
    hem, underarm, shoulder, neck = (
        np.array(CORNERS[name]) * [1, -1] for name in ("hem", "underarm", "shoulder", "neck")
    )
    low, high = np.array(CORNERS["sleeve"]) * [1, -1]
    half = [
        ("hem", np.array([[0.0, 0.0], hem])),
        ("right_side", np.array([hem, underarm])),
        ("right_underarm", np.array([underarm, low])),
        ("right_sleeve", np.array([low, high])),
        ("right_shoulder", np.array([high, shoulder, neck])),
        ("back_neck", _neckline(neck, NECK_DEPTH["back"], 0.5)),
    ]
    front = _neckline(neck, NECK_DEPTH["front"], 1.0)
    return Outline(mirrored(half), {"neck": np.concatenate([front, front[::-1][1:] * [1, -1]])})


def _neckline(neck: np.ndarray, depth: float, turn: float) -> np.ndarray:
    """Return the right half of a neckline, from the neck point to the middle, shape (k, 2).

    With `turn` 1 it is a quarter of an ellipse, steep at the shoulder; a smaller value makes it flatter there.
    """
    angle = np.linspace(0.0, 0.5 * np.pi, 25)
    x = neck[0] - depth * np.sin(angle) ** (1.0 / turn)
    return np.column_stack([x, neck[1] * np.cos(angle)])
