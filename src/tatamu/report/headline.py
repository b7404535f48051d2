"""Provides the top of a learned fold's page: the fold's name, its grade, and the main measures."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tatamu.report.measures import FAILED, GRADES, MEASURES, SUCCESS, Measure, grade
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result

GAUGE = (0.0005, 0.08)
"""Smallest and largest mean vertex distance [m] on the gauge, a bar that shows how good a fold is.

The scale of the gauge is logarithmic.
"""


def title(fold: Result) -> str:
    """Return the names of the garment and its fold as plain text, such as "Towel, half fold"."""
    task = fold.record.task
    step = f", step {task.step[0]} of {task.step[1]}" if task.step else ""
    return f"{spelled(task.garment)}, {task.fold} fold{step}"


def spelled(garment: str) -> str:
    """Return a garment's name with a capital letter, because it begins a title."""
    return "T-shirt" if garment == "tshirt" else garment[:1].upper() + garment[1:]


def word(fold: Result) -> str:
    """Return the grade of a learned fold: a word such as "good" if it succeeded, otherwise "failed"."""
    best = fold.record.best_score
    return grade(best.mean_vertex_distance) if best.succeeds else FAILED


def sureness(fold: Result) -> tuple[str, str] | None:
    """Return a fold's success rate in disturbed simulations as text, and its grade, which sets the colour.

    The rate comes from the results of `tatamu margins` if they exist, otherwise from the study. The result is None if
    neither of them contains a rate.
    """
    margins = ResultFolder(fold.folder).margins if fold.folder else None
    success = margins.together if margins else fold.record.success
    return None if success is None else (success.headline, success.tone)


@dataclass(frozen=True)
class Gauge:
    """A bar that is divided into grades, with a needle at the mean vertex distance of a fold.

    All positions and widths are in per cent of the bar's length.
    """

    zones: list[tuple[str, float]]
    """Name of each grade, and width of its part of the bar."""
    ticks: list[tuple[float, str]]
    """Position and label of each limit between two neighbouring grades."""
    success: tuple[float, str]
    """Position and label of the limit between success and failure."""
    needle: float
    """Position of the needle, which shows the fold's mean vertex distance."""


def gauge(fold: Result) -> Gauge:
    """Return the gauge of a learned fold."""
    ends = [GAUGE[0], *(end for end, _ in GRADES), GAUGE[1]]
    words = [*(name for _, name in GRADES), FAILED]
    widths = [_share(high) - _share(low) for low, high in pairwise(ends)]
    return Gauge(
        zones=list(zip(words, widths, strict=True)),
        ticks=[(_share(end), f"{1e3 * end:g}{' mm' if end == ends[-2] else ''}") for end, _ in GRADES],
        success=(_share(SUCCESS), f"success below {1e3 * SUCCESS:g} mm"),
        needle=_share(fold.record.best_score.mean_vertex_distance),
    )


def _share(distance: float) -> float:
    """Return the position of a distance [m] on the gauge [%]."""
    low, high = np.log(GAUGE)
    return float(np.clip(100 * (np.log(max(distance, 1e-9)) - low) / (high - low), 1.0, 99.0))


def events(fold: Result) -> list[tuple[float, str]]:
    """Return the marks under the replay's time slider: the times at which the hands start, arrive and open.

    Each mark has a position, as a fraction of the whole time, and a word.
    """
    end = float(fold.rollout.times[-1])
    timing = fold.description.timing_values
    known = (("starts", "start"), ("arrives", "arrive"), ("opens", "open"))
    return [(min(timing[name] / end, 1.0), word) for name, word in known if name in timing and end > 0]


def tiles() -> list[Measure]:
    """Return the most important measures of a fold, which the page shows in large type."""
    keys = ("mean_vertex_distance", "mask_iou", "area_error", "slip", "residual_bend", "trajectory_length")
    return [measure for measure in MEASURES if measure.key in keys]
