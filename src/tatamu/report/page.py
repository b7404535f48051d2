"""Writes the HTML page of a learned fold, and the frame that shows the fold inside another page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tatamu.base.errors import InputError
from tatamu.base.files import write_text
from tatamu.base.version import __version__
from tatamu.evaluation.outcome import HELP
from tatamu.report import command, errormap, headline, histogram, paths, search, tables, topview
from tatamu.report.conclusion import of_fold
from tatamu.report.measures import MEASURES, SUCCESS
from tatamu.report.still import render as still
from tatamu.show.chart import Chart
from tatamu.show.image import data_uri
from tatamu.show.page import render
from tatamu.show.replay import HAND_COLOURS, HandTrack, replay_data
from tatamu.show.shading import shrink, to_pixels
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result


def write_report(fold: Result, file: Path | None = None) -> Path:
    """Write the page of a learned fold, and return its path.

    Args:
        fold: The learned fold.
        file: File to write; None for `report.html` in the fold's folder.

    Raises:
        InputError: If the file cannot be written, or the fold has no folder and no file is given.
    """
    out = file_of(fold.folder, file)
    write_text(out, page(fold))
    return out


def file_of(folder: Path | None, file: Path | None) -> Path:
    """Return the file of a page: the given one, or else `report.html` in the folder of the result."""
    if file is None and folder is None:
        raise InputError("file: must be given, because the result has no folder")
    return file or ResultFolder(Path(folder or "")).report_file


def page(fold: Result) -> str:
    """Return the page of a learned fold as HTML. The same fold always gives the same bytes."""
    own = histogram.histogram(fold.errors, histogram.bin_width(float(fold.errors.max())))
    return render(
        "report/page.html",
        charts={
            "map": errormap.maps(fold),
            "own": [Chart("Errors at their own scale", own)],
            "moment": histogram.along(fold.moments),
            "objective": [Chart("Best so far", search.objective(fold.record))],
            "distance": [Chart("Each trial’s error", search.distance(fold.record))],
            "paths": [Chart("Hands in the plane of the fold", paths.plot(fold), kind="tall")],
        },
        replay=replay(fold, errormap.largest(fold.errors)),
        version=fold.record.tatamu or __version__,
        title=headline.title(fold),
        verdict=headline.word(fold),
        sureness=headline.sureness(fold),
        result=fold.record,
        success=SUCCESS,
        help=HELP,
        gauge=headline.gauge(fold),
        events=headline.events(fold),
        tiles=headline.tiles(),
        views=topview.beside(fold, fold.target),
        failures=topview.failures(fold),
        columns=tables.measures(fold),
        measures=MEASURES,
        control_points=tables.control_points(fold),
        parameters=tables.parameters(fold),
        timing=tables.timing(fold),
        material=tables.material(fold),
        task=tables.task(fold),
        warnings=tables.warnings(fold),
        conclusion=of_fold(fold.record),
        learn_command=command.learn(fold),
        simulate_command=command.simulate(fold),
    )


def replay(fold: Result, largest: float) -> dict[str, Any]:
    """Return the data for the replay of a learned fold.

    Colours show the distance of each vertex from its target, up to `largest` [m].
    """
    return replay_data(fold.rollout, fold.scene, hands(fold), largest)


def hands(fold: Result) -> list[HandTrack]:
    """Return the motions of the hands of a learned fold."""
    timing = fold.description.timing
    hold = (timing.closes, timing.opens) if timing else (0.0, None)
    return [HandTrack(colour, fold.hand(arm), [hold]) for colour, arm in zip(HAND_COLOURS, fold.arms, strict=False)]


def embedded(fold: Result) -> str:
    """Return HTML that shows a learned fold inside another page. The same fold always gives the same bytes."""
    frame = render(
        "report/frame.html",
        replay=replay(fold, errormap.largest(fold.errors)),
        title=headline.title(fold),
        events=headline.events(fold),
    )
    return render(
        "report/notebook.html",
        title=headline.title(fold),
        verdict=headline.word(fold),
        sureness=headline.sureness(fold),
        conclusion=of_fold(fold.record).text,
        picture=data_uri(to_pixels(shrink(still(fold), 4))),
        measures=[(measure, measure.text(fold.record.best_score)) for measure in MEASURES],
        frame=frame,
    )
