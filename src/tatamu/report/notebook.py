"""Shows a learned fold in a notebook: its picture, its measures, and the replay in an iframe."""

from __future__ import annotations

from tatamu.report import errormap, headline
from tatamu.report.conclusion import of_fold
from tatamu.report.measures import MEASURES
from tatamu.report.replay import replay
from tatamu.report.still import render as still
from tatamu.show.image import data_uri
from tatamu.show.page import render
from tatamu.show.shading import shrink, to_pixels
from tatamu.study.result import Result

SMALLER = 4
"""Factor by which the picture in the notebook is smaller than the rendered image."""


def embedded(fold: Result) -> str:
    """Return HTML that shows a learned fold inside another page. The same fold always gives the same bytes."""
    return render(
        "report/notebook.html",
        title=headline.title(fold),
        verdict=headline.word(fold),
        sureness=headline.sureness(fold),
        conclusion=of_fold(fold.record).text,
        picture=data_uri(to_pixels(shrink(still(fold), SMALLER))),
        measures=[(measure, measure.text(fold.record.best_score)) for measure in MEASURES],
        frame=replay_page(fold),
    )


def replay_page(fold: Result) -> str:
    """Return an HTML page that contains only the replay of a fold."""
    return render(
        "report/frame.html",
        replay=replay(fold, errormap.largest(fold.errors)),
        title=headline.title(fold),
        events=headline.events(fold),
    )
