"""Trousers: front and back sewn along outer and inner legs; open at waist and both hems."""

from __future__ import annotations

import numpy as np

from tatamu.garments.garment import Garment
from tatamu.garments.outline import Outline, mirrored
from tatamu.garments.sewing import front_and_back
from tatamu.material import Material
from tatamu.presets import load_preset

FABRIC = "usual-trousers"
"""A preset."""
SIZE = (0.34, 0.60)
"""Width over both hems and length [m] of a child of three to four: waist 10 in (25.4 cm) laid flat, full length 23.5 in
(60 cm) (Stone Harbor, chart of garment measurements)."""
OPENINGS = ("waist", "right_hem", "left_hem")
CORNERS = {"inner_hem": (0.0, 0.035), "outer_hem": (0.0, 0.17), "hip": (0.44, 0.157), "waist": (0.60, 0.127)}
"""Corners of the left half [m], x from the hems, y from the middle; waist and length are those of the chart.

Hem (13.5 cm), hip (31 cm laid flat) and crotch (19 cm below the waist) are assumed. There is a small gap between the
legs, as when hands lay them out."""
CROTCH = (0.41, 0.012)
"""Height of the crotch and half the distance of the legs just below it [m]; the crotch is round."""


def trousers(
    size: tuple[float, float] | None = None, material: Material | None = None, spacing: float | None = None
) -> Garment:
    """Trousers of width (over both hems, y) and length (x) [m]; hems at x < 0, waist at x > 0.

    Raises:
        InputError: A size or a spacing that no trousers have.
    """
    material = material or load_preset(FABRIC).material
    return front_and_back("trousers", pattern().fitted(size or SIZE), OPENINGS, material, spacing)


def pattern() -> Outline:
    """Return the outline of front and back in the size SIZE."""
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
