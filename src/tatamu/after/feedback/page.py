"""The page of measured folds: the numbers, the inferred errors, and the expected gain of the correction."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.after.feedback.folder import FeedbackFolder
from tatamu.after.feedback.measured import RULER_SOURCE
from tatamu.after.feedback.observe import Feedback
from tatamu.after.feedback.photo import draw_explained, simulated
from tatamu.after.feedback.posterior import Fold
from tatamu.after.feedback.texts import BEYOND, MARK_TITLES, NOTHING, again, by_gain, shift_text
from tatamu.base.files import write_text
from tatamu.cameras.pictures import write_picture
from tatamu.cameras.reading import FoldReading
from tatamu.evaluation.disturbances.channels import channel_of
from tatamu.folding.manipulation import HANDS
from tatamu.folding.score import MARKS, Limits
from tatamu.report.headline import title as fold_title
from tatamu.report.topview import TopView, drawn, extent, mask, outlined, painted, view
from tatamu.show.chart import Chart, Plot, axis, line, rows, traces
from tatamu.show.image import jpeg_uri
from tatamu.show.page import render


def write_page(found: Feedback, file: Path, reading: FoldReading | None = None) -> None:
    """Write `observed/observation.html`, and the picture of a photograph beside the file of its measured fold.

    Args:
        found: What the measured folds tell.
        file: The file of the newest measured fold.
        reading: What was read from its photograph; None if it was measured by a ruler.
    """
    if reading is not None:
        write_picture(draw_explained(found, reading), file.with_suffix(".jpg"))
    write_text(FeedbackFolder(found.learned.folder or Path()).page_file, page(found))


def page(found: Feedback) -> str:
    """Return the page of the measured folds as HTML. The same folds give the same bytes."""
    posterior, correction = found.posterior, found.correction
    return render(
        "after/feedback/page.html",
        charts={
            "told": [Chart("What is the same in every fold", _told(found), kind="rows")],
            "gain": [Chart("The next fold", _gain(found))],
        },
        title=fold_title(found.learned),
        found=found,
        posterior=posterior,
        correction=correction,
        nothing=NOTHING,
        again=again(found) if posterior.used else None,
        tone="fair" if correction.is_none else "near-perfect",
        headline=_headline(found),
        warnings=[f"Measured fold {number} is {BEYOND}." for number in found.implausible],
        views=_views(found),
        photos=_photos(found),
        folds=[(number, _rows(found, fold)) for number, fold in enumerate(found.folds, start=1)],
        told=[
            (error.title, error.spread(before), error.spread(after), error.text(mean))
            for error, mean, before, after in by_gain(found)
        ],
        alike=[
            (channel_of(each.one).title, channel_of(each.other).title, f"{each.correlation:+.2f}")
            for each in posterior.alike()
        ],
        undetermined=[channel_of(name).title for name in posterior.undetermined()],
        hands=[(hand, shift_text(shift)) for hand, shift in zip(HANDS, correction.shifts, strict=False)],
        expected=_expected(found),
    )


def _headline(found: Feedback) -> str:
    correction = found.correction
    if correction.is_none:
        return "nothing to correct"
    before, after = (1e3 * each.distance for each in (correction.before, correction.after))
    return f"{before:.1f} mm, corrected {after:.1f} mm"


def _predicted(found: Feedback, fold: Fold) -> np.ndarray:
    """Return the marks that the inferred errors predict for a measured fold [m], shape (m,)."""
    return fold.emulator.marks(found.posterior.mean + fold.correction)


def _rows(found: Feedback, fold: Fold) -> list[tuple[str, list[str]]]:
    """Return a row for each mark: measured value, deviation, and the values expected before and after inference."""
    measured = {number.name: number for number in fold.measured.measured}
    prior = fold.emulator.marks(found.posterior.prior.mean + fold.correction)
    known = _predicted(found, fold)
    rows = []
    for place, name in enumerate(MARKS):
        number = measured.get(name)
        cells = ["not measured", ""] if number is None else [_mm(number.value), f"{1e3 * number.deviation:.1f} mm"]
        rows.append((MARK_TITLES[name], [*cells, _mm(prior[place]), _mm(known[place])]))
    return rows


def _expected(found: Feedback) -> list[tuple[str, list[str]]]:
    """Return table rows for the expected outcome of the next fold, without and with the correction."""
    both = (found.correction.before, found.correction.after)
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
    within = [f"{100 * each.within:.0f} %" for each in both]
    return [*rows, ("mean vertex distance", distance), ("folds within the limit", within)]


def _mm(value: float) -> str:
    return f"{1e3 * value:+.1f} mm".replace("-", "−")


def _told(found: Feedback) -> Plot:
    """Return a chart of means and standard deviations, both divided by the standard deviation before."""
    told = by_gain(found)[::-1]
    names = [error.title for error, *_ in told]
    means = [mean / before for _, mean, before, _ in told]
    spread = [after / before for *_, before, after in told]
    end = 0.2 + max([1.0, *(abs(mean) + each for mean, each in zip(means, spread, strict=True))])
    return traces(
        [
            _points(names, [0.0] * len(told), [1.0] * len(told), "before", "@line", 9),
            _points(names, means, spread, "after", "@plot", 4),
        ],
        **rows(names),
        xaxis=axis("standard deviations as stated before", range=[-end, end]),
        shapes=[line("x", 0.0, dash="solid")],
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


def _gain(found: Feedback) -> Plot:
    """Return histograms of the judged distance of the next fold, without and with the correction."""
    posterior, correction = found.posterior, found.correction
    emulator = found.emulator
    nothing = np.zeros(len(posterior.names))
    cases = (("without correction", nothing, "@line"), ("with it", correction.change, "@plot"))
    limit = 1e3 * Limits().mean_vertex_distance
    drawn = [1e3 * emulator.judged_distances(posterior.ends(emulator, change)) for _, change, _ in cases]
    most = float(min(max(np.quantile(each, 0.995) for each in drawn), 6.0 * limit))
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
        for (name, _, colour), values in zip(cases, drawn, strict=True)
    ]
    return traces(
        data,
        barmode="overlay",
        xaxis=axis("mean distance of the moved part [mm]", range=[0.0, most]),
        yaxis=axis("next folds"),
        shapes=[line("x", limit, colour="@failed", dash="dash")],
    )


def _views(found: Feedback) -> list[TopView]:
    """Return views of the folded cloth from above: with the inferred errors, and as expected after the correction."""
    if not found.posterior.used:
        return []
    corrections = [("As explained", "the cloth after the last measured fold", found.folds[found.newest].correction)]
    if not found.correction.is_none:
        corrections.append(("Next", "the cloth as expected after the correction", found.correction.change))
    target = found.subject.task.fold.target
    ends = [(name, note, simulated(found, change)) for name, note, change in corrections]
    finals = [(name, note, final) for name, note, final in ends if final is not None]
    # larger pictures would take most of the time of the page
    area = extent(target, *(final for *_, final in finals), wide=400)
    wanted = mask(painted(found.learned, target), area)
    images = drawn(found.learned, (final for *_, final in finals), area)
    return [
        view(name, note, outlined(image, wanted), area)
        for (name, note, _), (image, _) in zip(finals, images, strict=True)
    ]


def _photos(found: Feedback) -> dict[int, str]:
    """Return the saved photographs as data URIs, by the place of the measured fold, counted from 1."""
    pairs = enumerate(zip(found.files, found.folds, strict=False), start=1)
    files = {n: file.with_suffix(".jpg") for n, (file, fold) in pairs if fold.measured.source != RULER_SOURCE}
    return {place: jpeg_uri(file) for place, file in files.items() if file.exists()}
