"""The replay of a learned fold: its data for pages, and a frame in a notebook with the picture and the measures."""

from __future__ import annotations

from typing import Any

from tatamu.report import errormap, headline
from tatamu.report.conclusion import of_fold
from tatamu.report.measures import MEASURES
from tatamu.report.still import render as still
from tatamu.show.image import data_uri
from tatamu.show.page import render
from tatamu.show.replay import HAND_COLOURS, HandTrack, replay_data
from tatamu.show.shading import shrink, to_pixels
from tatamu.study.result import Result


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
