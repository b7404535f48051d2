"""Writes the HTML page of a learned fold."""

from __future__ import annotations

from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.base.files import write_text
from tatamu.base.version import __version__
from tatamu.evaluation.outcome import HELP
from tatamu.report import command, errormap, headline, histogram, paths, search, tables, topview
from tatamu.report.conclusion import of_fold
from tatamu.report.measures import MEASURES, SUCCESS
from tatamu.report.replay import replay
from tatamu.show.chart import Chart
from tatamu.show.page import render
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
