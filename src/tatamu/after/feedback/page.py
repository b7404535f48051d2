"""The page of an observed fold: the measurement, the inferred errors, and the expected gain of the correction."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.after.feedback.correction import WORTH
from tatamu.after.feedback.explained import simulated
from tatamu.after.feedback.folder import ObservedFolder
from tatamu.after.feedback.observe import BEYOND, Observed
from tatamu.after.feedback.posterior import Fold
from tatamu.after.feedback.texts import MARK_TITLES, deviation, learned_most, shift_text, shown, title
from tatamu.base.files import write_text
from tatamu.folding.fold import Fold as TargetFold
from tatamu.folding.manipulation import HANDS
from tatamu.folding.marks import MARKS
from tatamu.folding.score import Limits
from tatamu.report.headline import title as fold_title
from tatamu.report.topview import TopView, draw, extent, mask, outlined, view
from tatamu.show.chart import Chart, Plot, axis, line, traces
from tatamu.show.image import jpeg_uri
from tatamu.show.page import render
from tatamu.simulation.mesh.topology import facing_down

WIDE = 400
"""Width of a picture in the file [pixels]. Larger pictures would take most of the time of the page."""


@dataclass(frozen=True)
class _Cloth:
    """The cloth for pictures, with the mesh on which the draws of the disturbances were simulated."""

    fold: TargetFold

    @property
    def faces(self) -> np.ndarray:
        return self.fold.garment.faces

    @property
    def start(self) -> np.ndarray:
        return self.fold.start

    @property
    def lower(self) -> np.ndarray:
        return facing_down(self.fold.garment.vertices, self.faces)


def write_page(observed: Observed) -> Path:
    """Write `observed/observation.html` into the folder of the learned fold, and return its path."""
    path = ObservedFolder(observed.learned.folder or Path()).page_file
    write_text(path, page(observed))
    return path


def page(observed: Observed) -> str:
    """Return the page of the observed folds as HTML. The same observations give the same bytes."""
    posterior, correction = observed.posterior, observed.correction
    return render(
        "after/feedback/page.html",
        charts={
            "told": [Chart("What is the same in every fold", _told(observed), kind="tall broad")],
            "gain": [Chart("The next fold", _gain(observed))],
        },
        title=fold_title(observed.learned),
        observed=observed,
        posterior=posterior,
        correction=correction,
        worth=f"{1e3 * WORTH:.1f}",
        tone="fair" if correction.is_none else "near-perfect",
        headline=_headline(observed),
        warnings=[f"Observed fold {number} is {BEYOND}." for number in observed.implausible],
        views=_views(observed),
        photos=_photos(observed),
        folds=[(number, _rows(observed, fold)) for number, fold in enumerate(observed.folds, start=1)],
        told=[
            (title(name), deviation(name, before), deviation(name, after), shown(name, mean))
            for name, mean, before, after in learned_most(observed)
        ],
        alike=[(title(each.one), title(each.other), f"{each.correlation:+.2f}") for each in posterior.alike()],
        untold=[title(name) for name in posterior.untold()],
        hands=[(hand, shift_text(shift)) for hand, shift in zip(HANDS, correction.shifts, strict=False)],
        expected=_expected(observed),
    )


def _headline(observed: Observed) -> str:
    correction = observed.correction
    if correction.is_none:
        return "nothing to correct"
    before, after = (1e3 * each.distance for each in (correction.before, correction.after))
    return f"{before:.1f} mm expected, {after:.1f} mm after the correction"


def _predicted(observed: Observed, fold: Fold) -> np.ndarray:
    """Return the m marks (measured lengths) that the inferred errors predict for an observed fold [m], shape (m,)."""
    return fold.emulator.marks(observed.posterior.mean + fold.correction)


def _rows(observed: Observed, fold: Fold) -> list[tuple[str, list[str]]]:
    """Return a table row for each mark (measured length) of an observed fold.

    A row has the measured value, its standard deviation, and the expected value before and after all observations.
    """
    measured = {number.name: number for number in fold.observation.measured}
    prior = fold.emulator.marks(observed.posterior.prior.mean + fold.correction)
    known = _predicted(observed, fold)
    rows = []
    for place, name in enumerate(MARKS):
        number = measured.get(name)
        cells = ["not measured", ""] if number is None else [_mm(number.value), f"{1e3 * number.deviation:.1f} mm"]
        rows.append((MARK_TITLES[name], [*cells, _mm(prior[place]), _mm(known[place])]))
    return rows


def _expected(observed: Observed) -> list[tuple[str, list[str]]]:
    """Return table rows for the expected outcome of the next fold, without and with the correction."""
    both = (observed.correction.before, observed.correction.after)
    rows = [
        (
            MARK_TITLES[name],
            [
                f"{_mm(each.marks[place])} ({_mm(each.intervals[place][0])} to {_mm(each.intervals[place][1])})"
                for each in both
            ],
        )
        for place, name in enumerate(MARKS)
    ]
    distance = [
        f"{1e3 * each.distance:.1f} mm ({1e3 * each.distance_interval[0]:.1f} to {1e3 * each.distance_interval[1]:.1f})"
        for each in both
    ]
    return [*rows, ("mean vertex distance", distance)]


def _mm(value: float) -> str:
    return f"{1e3 * value:+.1f} mm".replace("-", "−")


def _told(observed: Observed) -> Plot:
    """Return a chart of each error of the set-up before and after the observations.

    The points are means, and the bars are standard deviations. Both are divided by the standard deviation before the
    observations.
    """
    rows = learned_most(observed)[::-1]
    names = [title(name) for name, *_ in rows]
    means = [mean / before for _, mean, before, _ in rows]
    spread = [after / before for *_, before, after in rows]
    return traces(
        [
            _points(names, [0.0] * len(rows), [1.0] * len(rows), "before", "@line", 9),
            _points(names, means, spread, "after", "@plot", 4),
        ],
        margin={"l": 220, "r": 20, "t": 30, "b": 44},
        xaxis=axis("standard deviations as stated before", zeroline=True),
        yaxis={"automargin": True, "ticks": ""},
    )


def _points(
    names: Sequence[str], middles: Sequence[float], spread: Sequence[float], name: str, colour: str, width: int
) -> dict[str, Any]:
    """Return one point for each name, with a horizontal error bar, as a trace of a chart."""
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "y": list(names),
        "x": [round(value, 3) for value in middles],
        "error_x": {
            "type": "data",
            "array": [round(value, 3) for value in spread],
            "color": colour,
            "thickness": width,
            "width": 0,
        },
        "marker": {"color": colour, "size": 8},
    }


def _gain(observed: Observed) -> Plot:
    """Return histograms of the mean vertex distance of the next fold, without and with the correction."""
    posterior, correction = observed.posterior, observed.correction
    emulator = observed.emulator
    nothing = np.zeros(len(posterior.names))
    cases = (("without correction", nothing, "@line"), ("with it", correction.change, "@plot"))
    limit = 1e3 * Limits().mean_vertex_distance
    found = [1e3 * emulator.distances(posterior.ends(emulator, change)) for _, change, _ in cases]
    most = float(min(max(np.quantile(each, 0.995) for each in found), 6.0 * limit))
    bins = {"start": 0.0, "end": most, "size": max(0.5, round(most / 30.0, 1))}
    data = [
        {
            "type": "histogram",
            "name": name,
            "x": [round(float(value), 2) for value in values if value <= most],
            "xbins": bins,
            "opacity": 0.7,
            "marker": {"color": colour},
        }
        for (name, _, colour), values in zip(cases, found, strict=True)
    ]
    return traces(
        data,
        barmode="overlay",
        xaxis=axis("mean vertex distance [mm]", range=[0.0, most]),
        yaxis=axis("members"),
        shapes=[line("x", limit, colour="@failed", dash="dash")],
    )


def _views(observed: Observed) -> list[TopView]:
    """Return views of the folded cloth from above: with the inferred errors, and as expected after the correction."""
    if not observed.posterior.used:
        return []
    corrections = [
        ("As explained", "the cloth after the last observed fold", observed.folds[observed.newest].correction)
    ]
    if not observed.correction.is_none:
        corrections.append(("Next", "the cloth as expected after the correction", observed.correction.change))
    cloth = _Cloth(observed.draws.mesh.evaluator.task.fold)
    ends = [(name, note, simulated(observed, change)) for name, note, change in corrections]
    finals = [(name, note, final) for name, note, final in ends if final is not None]
    area = extent(cloth.fold.target, *(final for *_, final in finals), wide=WIDE)
    wanted = mask(cloth, cloth.fold.target, area)

    def picture(end: tuple[str, str, np.ndarray]) -> TopView:
        name, note, final = end
        return view(name, note, outlined(draw(cloth, final, area)[0], wanted), area)

    with ThreadPoolExecutor() as workers:
        return list(workers.map(picture, finals))


def _photos(observed: Observed) -> dict[int, str]:
    """Return the saved photographs as data URIs for the page, by the number of the observed fold, counted from 1."""
    if observed.learned.folder is None:
        return {}
    files = enumerate(ObservedFolder(observed.learned.folder).photos(), start=1)
    return {number: jpeg_uri(file) for number, file in files if file.exists()}
