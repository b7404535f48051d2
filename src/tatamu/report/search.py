"""Draws charts of the search: the objective and the mean vertex distance of each trial."""

from __future__ import annotations

import html
from typing import Any

import numpy as np

from tatamu.report.measures import GRADES
from tatamu.show.chart import Plot, axis, dots, line, note, traces
from tatamu.study.record import ResultRecord
from tatamu.study.trial import Trial


def objective(result: ResultRecord) -> Plot:
    """Return a chart of the objective of each trial, with a line for the best objective so far on each mesh."""
    done = [trial for trial in result.trials if trial.state == "complete" and trial.objective is not None]
    values = [trial.minimised for trial in done]
    top = max(values) + 0.08 * (max(values) - min(values) or 1.0)
    least = result.best_trial.minimised
    best = np.minimum.accumulate(values).tolist()
    return traces(
        [
            *_both(done, values, "C = %{y:.4f}"),
            {
                "x": [*(trial.number for trial in done), *(trial.number for trial in result.trials[-1:] if done)],
                "y": [*best, *best[-1:]],
                "mode": "lines",
                "line": {"color": "@plot", "width": 2.5, "shape": "hv"},
                "hovertemplate": "best so far %{y:.4f}<extra></extra>",
            },
            _failed(result.trials, top),
            _star(result.best_trial.number, least, "C = %{y:.4f}"),
        ],
        xaxis=_trials(result),
        yaxis=axis("objective C" if result.disturbances is None else "C, with penalties"),
        hovermode="closest",
    )


def distance(result: ResultRecord) -> Plot:
    """Return a chart of the mean vertex distance of each trial, with thresholds from the literature."""
    scored = [(trial, trial.score) for trial in result.trials if trial.score is not None]
    done = [trial for trial, _ in scored]
    values = [1e3 * max(score.mean_vertex_distance, 1e-5) for _, score in scored]
    low = min([*values, 1.0]) / 1.4
    high = max([*values, 30.0]) * 1.4
    best = 1e3 * result.best_score.mean_vertex_distance
    marks = [line("y", 1e3 * end, opacity=0.8) for end, _ in GRADES]
    ends = [low, *(1e3 * end for end, _ in GRADES), high]
    words = [*(word for _, word in GRADES), "failed"]
    # On a logarithmic axis, Plotly expects the logarithms of the positions of annotations.
    notes = [
        note(1, float(np.log10(np.sqrt(a * b))), word, xref="paper", xanchor="left", xshift=6)
        for word, a, b in zip(words, ends, ends[1:], strict=False)
    ]
    return traces(
        [
            *_both(done, values, "%{y:.2f} mm"),
            _failed(result.trials, high / 1.15),
            _star(result.best_trial.number, max(best, 0.01), "%{y:.2f} mm"),
        ],
        xaxis=_trials(result),
        yaxis=axis(
            "mean vertex distance [mm]",
            type="log",
            range=np.log10([low, high]).tolist(),
            tickvals=[0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500],
        ),
        margin={"l": 52, "r": 86, "t": 16, "b": 44},
        shapes=marks,
        annotations=notes,
        hovermode="closest",
    )


def _trials(result: ResultRecord) -> dict[str, Any]:
    last = result.trials[-1].number
    return axis("trial", range=[-0.03 * last - 0.5, last * 1.03 + 0.5], showgrid=False)


def _both(trials: list[Trial], values: list[float], text: str) -> list[dict[str, Any]]:
    """Return filled dots, and hollow dots for trials that failed in a scenario."""
    shown: dict[str, list[tuple[int, float]]] = {}
    for trial, value in zip(trials, values, strict=True):
        shown.setdefault(_failure(trial), []).append((trial.number, value))
    plots = []
    for kind in sorted(shown, reverse=True):
        numbers, heights = zip(*shown[kind], strict=True)
        words = f"trial %{{x}}<br>{text}{kind and '<br>' + kind}"
        if kind:
            plots.append(dots(numbers, heights, words, symbol="circle-open", size=6.5, color="@muted", opacity=0.8))
        else:
            plots.append(dots(numbers, heights, words, symbol="circle", size=6.5, color="@plot", opacity=0.5))
    return plots


def _failure(trial: Trial) -> str:
    """Return in which scenarios a trial failed; empty if it did not fail in any."""
    tried = trial.scenarios
    failed = tried is not None and tried.succeeded < tried.simulated
    return f"failed in a scenario, after {tried.succeeded} passed" if failed and tried else ""


def _star(number: int, value: float, text: str) -> dict[str, Any]:
    edge = {"color": "@card", "width": 2}
    return dots([number], [value], f"best: trial %{{x}}<br>{text}", size=13, color="@accent", line=edge)


def _failed(trials: list[Trial], height: float) -> dict[str, Any]:
    """Return crosses for failed trials along the upper edge of the chart, because a failed trial has no value."""
    failed = [trial for trial in trials if trial.state == "failed"]
    return dots(
        [trial.number for trial in failed],
        [height] * len(failed),
        "trial %{x} failed: %{text}",
        text=[html.escape(trial.error or "no reason given") for trial in failed],
        symbol="x-thin",
        size=7,
        line={"color": "@muted", "width": 1.5},
    )
