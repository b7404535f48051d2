"""Makes trousers: a front and a back, sewn along the outer and inner legs, open at the waist and both hems."""

from __future__ import annotations

import numpy as np

from tatamu.garments.garment import Garment
from tatamu.garments.outline import Outline, mirrored
from tatamu.garments.sewing import front_and_back
from tatamu.simulation.material import Material
from tatamu.simulation.presets import load_preset

SIZE = (0.34, 0.60)
"""Width over both hems and length [m] for a child of three to four years, by a chart of garment measurements by Stone
Harbor: the waist laid flat is 10 in (25.4 cm), the full length 23.5 in (60 cm)."""
OPENINGS = ("waist", "right_hem", "left_hem")
CORNERS = {"inner_hem": (0.0, 0.035), "outer_hem": (0.0, 0.17), "hip": (0.44, 0.157), "waist": (0.60, 0.127)}
"""Corners of the left half [m], x from the hems and y from the middle. Waist and length are from the chart. The hem
(13.5 cm), the hip (31 cm laid flat) and the crotch (19 cm below the waist) are assumed, as is the small gap between the
legs, which hands leave that lay out trousers."""
CROTCH = (0.41, 0.012)
"""Distance of the round crotch from the hems, and half the distance between the legs just below it [m]."""


def trousers(
    size: tuple[float, float] | None = None, material: Material | None = None, spacing: float | None = None
) -> Garment:
    """Make trousers of a width (over both hems, y) and length (x) [m]. The hems are at x < 0, the waist at x > 0."""
    material = material or load_preset("usual-trousers").material
    return front_and_back("trousers", pattern().fitted(size or SIZE), OPENINGS, material, spacing)


def pattern() -> Outline:
    """Return the outline of the default trousers, the same for front and back."""
    inner, outer, hip, waist = (np.array(corner) * [1, -1] for corner in CORNERS.values())
    height, gap = CROTCH
    angle = np.linspace(0.0, 0.5 * np.pi, 9)
    crotch = np.column_stack([height - gap + gap * np.sin(angle), -gap * np.cos(angle)])
    half = [
        ("crotch", crotch[::-1]),
        ("right_inner", np.array([crotch[0], inner])),
        ("right_hem", np.array([inner, outer])),
        ("right_outer", np.array([outer, hip, waist])),
        ("waist", np.array([waist, [waist[0], 0.0]])),
    ]
    return Outline(mirrored(half))
