"""The page of a learned fold."""

from __future__ import annotations

from pathlib import Path

from tatamu import __version__
from tatamu.files import write_text
from tatamu.presentation.chart import Chart
from tatamu.presentation.page import Charts, render
from tatamu.report import command, errormap, headline, histogram, paths, search, tables, topview
from tatamu.report.conclusion import of_fold
from tatamu.report.replay import replay
from tatamu.report.verdict import MEASURES, SUCCESS
from tatamu.results import LearnedFold, ResultFolder, read_fold


def write_report(folder: Path) -> Path:
    """Write `report.html` into a result folder and return its path.

    Raises:
        InputError: A file is missing, broken, of another version or does not fit the others.
    """
    out = ResultFolder(Path(folder)).report_file
    write_text(out, page(read_fold(Path(folder))))
    return out


def page(fold: LearnedFold) -> str:
    """The whole page; the same fold gives the same bytes."""
    return render(
        "report/page.html",
        charts=_charts(fold),
        replay=replay(fold, errormap.largest(fold.errors)),
        version=fold.result.tatamu or __version__,
        title=headline.title(fold),
        verdict=headline.word(fold),
        sureness=headline.sureness(fold),
        least=fold.result.least_objective,
        result=fold.result,
        best=fold.result.best_trial,
        success=SUCCESS,
        gauge=headline.gauge(fold),
        events=headline.events(fold),
        tiles=headline.tiles(),
        views=topview.beside(fold, fold.target),
        columns=tables.measures(fold),
        measures=MEASURES,
        control_points=tables.control_points(fold),
        parameters=tables.parameters(fold),
        timing=tables.timing(fold),
        material=tables.material(fold),
        task=tables.task(fold),
        warnings=tables.warnings(fold),
        conclusion=of_fold(fold.result),
        learn_command=command.learn(fold),
        simulate_command=command.simulate(fold),
    )


def _charts(fold: LearnedFold) -> Charts:
    own = histogram.histogram(fold.errors, histogram.bin_width(float(fold.errors.max())))
    return {
        "map": errormap.maps(fold),
        "own": [Chart("Errors at their own scale", own)],
        "moment": histogram.along(fold.moments),
        "objective": [Chart("Best so far", search.objective(fold.result))],
        "distance": [Chart("Each trial’s error", search.distance(fold.result))],
        "paths": [Chart("Hands in the plane of the fold", paths.plot(fold), kind="tall")],
    }
