"""Defines the measures of a fold that pages show: their titles, grades and thresholds, with sources."""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.folding.score import Limits, Score
from tatamu.show.quantity import Quantity, number

GRADES = ((0.002, "near perfect"), (0.005, "good"), (0.020, "fair"))
"""Pairs of a limit [m] and a grade. A fold gets the first grade whose limit is above the fold's mean vertex distance.

If the distance is not below the last limit, the grade is `FAILED`.
"""
FAILED = "failed"
SUCCESS = Limits().mean_vertex_distance
"""Largest mean vertex distance of a successful fold [m]."""
OVERLAP = Limits().mask_iou
"""Smallest overlap of a successful fold with its target, seen from above (intersection over union)."""
AREA = 2.77
"""Largest area error of a fold that passes [%]. It is the lowest area error of other methods in publications."""


def grade(mean_vertex_distance: float | None) -> str:
    """Return the grade of a mean vertex distance [m]; `FAILED` if the distance is None, because the trial failed."""
    if mean_vertex_distance is None:
        return FAILED
    below = (word for end, word in GRADES if mean_vertex_distance < end)
    return next(below, FAILED)


@dataclass(frozen=True)
class Measure:
    """A measure of a fold, with its presentation and its threshold."""

    key: str
    """Name of the measure's field in result.json."""
    title: str
    """Name of the measure, as HTML."""
    unit: str
    """Unit on the page."""
    digits: int
    meaning: str
    """Meaning of the measure in a few words, as HTML."""
    threshold: str = ""
    limit: str = ""
    """Threshold for success in a few words."""
    source: str = ""
    most: float | None = None
    """Largest value that passes, in the unit of result.json; None if the measure has no upper limit."""
    least: float | None = None
    """Smallest value that passes, in the unit of result.json; None if the measure has no lower limit."""

    def value(self, score: Score | None) -> float | None:
        """Return the value of the measure, in the unit of result.json; None if the fold failed."""
        value = None if score is None else getattr(score, self.key)
        return None if value is None else float(value)

    def text(self, score: Score | None) -> str:
        """Return the value of the measure as text, in the unit of the page."""
        return self.number(self.value(score))

    def number(self, value: float | None) -> str:
        """Return a value in the unit of result.json as text, in the unit of the page."""
        return number(value, self.unit, f".{self.digits}f")

    @property
    def heading(self) -> str:
        """Title with the unit, as HTML."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def passes(self, score: Score | None) -> bool | None:
        """Return whether a fold's value of the measure meets the threshold.

        The result is None if there is no threshold or no value.
        """
        return Quantity(self.title, self.value(score), minimum=self.least, maximum=self.most).passes


MEASURES = (
    Measure(
        "mean_vertex_distance",
        "Mean vertex distance",
        "mm",
        1,
        "mean of e<sub>i</sub> over the mesh",
        "below {:g} near perfect, to {:g} good, above {:g} failed; ".format(*(1e3 * end for end, _ in GRADES))
        + f"below {1e3 * SUCCESS:g} success",
        f"success below {1e3 * SUCCESS:g} mm",
        "De Gusseme and wyffels 2022, Front. Neurorobot. 16:989702; success: BiFold 2025",
        most=SUCCESS,
    ),
    Measure(
        "moving_vertex_distance",
        "of the part that moves",
        "mm",
        1,
        "mean of e<sub>i</sub> over the part that the fold moves: half of the cloth may never move",
        f"below {1e3 * SUCCESS:g} success",
        f"success below {1e3 * SUCCESS:g} mm",
        most=SUCCESS,
    ),
    Measure(
        "mask_iou",
        "Mask IoU",
        "",
        3,
        "overlap of the two top views, intersection over union",
        f"at least {OVERLAP:.2f}",
        f"success from {OVERLAP:.2f}",
        "FoldBack 2026",
        least=OVERLAP,
    ),
    Measure(
        "area_error",
        "Area error E<sub>f</sub>",
        "%",
        2,
        "folded area against what the fold should leave (half, for a fold in half)",
        f"{AREA:g} reached",
        f"others reach {AREA:g} %",
        "Garcia-Camacho et al. 2020",
        most=AREA,
    ),
    Measure("slip", "Slip", "mm", 1, "how far the part that should lie still moved"),
    Measure(
        "residual_bend", "Residual bend", "mm", 1, "largest e<sub>i</sub> beyond μ + 1.28 σ", source="the paper, Fig. 2"
    ),
    Measure(
        "trajectory_length",
        "Path length l<sub>x</sub>",
        "m",
        3,
        "length of a hand’s path",
        source="the paper, Eq. (10)",
    ),
    Measure(
        "shape_distance",
        "Shape distance D",
        "m",
        3,
        "Σ w<sub>i</sub> e<sub>i</sub>; depends on the mesh",
        source="the paper, Eq. (11), Eq. (12), Eq. (13)",
    ),
    Measure(
        "objective",
        "Objective C",
        "",
        4,
        "l<sub>x</sub> + 0.01 D, what the search minimised",
        source="the paper, Eq. (10)",
    ),
)
