"""The head of the page: the fold's name, the verdict in words, the chief numbers, a gauge."""

from __future__ import annotations

import numpy as np

from tatamu.report.markup import text
from tatamu.report.verdict import FAILED, GRADES, MEASURES, SUCCESS, Measure, grade
from tatamu.results import LearnedFold

GAUGE = (0.0005, 0.08)
"""Ends of the gauge [m], on a logarithmic scale."""
TILES = ("mean_vertex_distance", "mask_iou", "area_error", "slip", "residual_bend", "trajectory_length")


def title(fold: LearnedFold) -> str:
    """What was folded how, plain text: "Towel, half fold"."""
    task = fold.result.task
    step = f", step {task.step[0]} of {task.step[1]}" if task.step else ""
    return f"{spelled(task.garment)}, {task.fold} fold{step}"


def spelled(garment: str) -> str:
    """The garment's name at the beginning of a title."""
    return "T-shirt" if garment == "tshirt" else garment[:1].upper() + garment[1:]


def sentence(fold: LearnedFold) -> str:
    """The verdict in words, as HTML."""
    result, best = fold.result, fold.result.best_trial
    error = best.mean_vertex_distance or 0.0
    took = f" and {result.wall_seconds:.0f} s" if result.wall_seconds is not None else ""
    side = "below" if error < SUCCESS else "not below"
    count = len(result.trials)
    trials = f"{count} trial{'s' if count != 1 else ''}"
    return (
        f"The cloth comes to rest <strong>{1e3 * error:.1f}&nbsp;mm</strong> from its target on average, "
        f"{side} the {1e3 * SUCCESS:g}&nbsp;mm that count as success. "
        f"Found in {trials}{took} of search; trial {result.best} was the best."
    )


def word(fold: LearnedFold) -> str:
    """The grade: near perfect, good, fair or failed."""
    return grade(fold.result.best_trial.mean_vertex_distance)


def gauge(fold: LearnedFold) -> str:
    """The mean vertex distance on a bar of the grades, as HTML."""
    ends = [GAUGE[0], *(end for end, _ in GRADES), GAUGE[1]]
    words = [*(name for _, name in GRADES), FAILED]
    zones = "".join(_zone(*zone) for zone in zip(words, ends, ends[1:], strict=False))
    ticks = "".join(_tick(end, f"{1e3 * end:g}{' mm' if end == ends[-2] else ''}") for end, _ in GRADES)
    success = _tick(SUCCESS, f"success below {1e3 * SUCCESS:g} mm", "success")
    error = fold.result.best_trial.mean_vertex_distance or 0.0
    needle = f'<span class="needle" style="left:{_share(error):.2f}%"></span>'
    label = f"Mean vertex distance on the scale of the thresholds: {word(fold)}"
    return (
        f'<div class="gauge" role="img" aria-label="{text(label)}">'
        f'<div class="bar">{zones}{needle}</div>{ticks}{success}</div>'
    )


def _zone(name: str, start: float, end: float) -> str:
    width = _share(end) - _share(start)
    return f'<span class="zone {name.replace(" ", "-")}" style="width:{width:.2f}%">{name}</span>'


def _tick(place: float, label: str, kind: str = "") -> str:
    return f'<span class="tick {kind}" style="left:{_share(place):.2f}%">{label}</span>'


def _share(distance: float) -> float:
    """Place on the gauge [%] of a distance [m]."""
    low, high = np.log(GAUGE)
    return float(np.clip(100 * (np.log(max(distance, 1e-9)) - low) / (high - low), 1.0, 99.0))


def events(fold: LearnedFold) -> str:
    """Marks under the time slider: when the hands start, arrive and open, as HTML."""
    end = float(fold.rollout.times[-1])
    timing = fold.manipulation.timing_values
    known = (("starts", "start"), ("arrives", "arrive"), ("opens", "open"))
    return "".join(
        f'<span style="--at:{min(timing[name] / end, 1.0):.4f}">{word}</span>'
        for name, word in known
        if name in timing and end > 0
    )


def tiles(fold: LearnedFold) -> str:
    """The chief measures, large, as HTML."""
    chosen = {measure.key: measure for measure in MEASURES}
    return "".join(_tile(chosen[key], fold) for key in TILES)


def _tile(measure: Measure, fold: LearnedFold) -> str:
    best = fold.result.best_trial
    passes = measure.passes(best)
    state = {None: "", True: "yes", False: "no"}[passes]
    return (
        f'<div class="tile {state}"><span class="value">{measure.text(best)}<i>{measure.unit}</i></span>'
        f'<span class="name">{measure.title}</span>'
        f'<span class="limit">{measure.limit or measure.meaning}</span></div>'
    )
