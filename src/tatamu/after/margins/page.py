"""The page of margins, which shows the disturbances that a fold tolerates.

It has the range of each disturbance, the results of joint draws, and a replay of the worst draws. A joint draw is one
random value of every disturbance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.after.margins.measurement import Draw, Measured
from tatamu.after.margins.texts import by_sureness, deviations, reach, simulated
from tatamu.after.margins.texts import rows as range_rows
from tatamu.base.errors import SimulationError
from tatamu.base.files import write_text
from tatamu.evaluation.disturbances import disturbed_scene
from tatamu.evaluation.disturbances.channels import channel_of
from tatamu.evaluation.draws import Subject
from tatamu.evaluation.outcome import HELP
from tatamu.evaluation.success import AloneMargin, MarginsRecord
from tatamu.folding.manipulation import HANDS
from tatamu.report.errormap import largest
from tatamu.report.headline import title
from tatamu.show.chart import Chart, Plot, axis, line, rows, traces
from tatamu.show.page import render
from tatamu.show.replay import HAND_COLOURS, HandTrack, replay_data
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.side_by_side import executor_of
from tatamu.simulation.simulators import capabilities, simulate

REPLAYED = 3
"""Number of the worst draws that the page replays."""


@dataclass(frozen=True)
class Replayed:
    """A draw of the disturbances that the page replays."""

    draw: Draw
    scene: Scene
    rollout: Rollout


def write_page(measured: Measured, out: Path) -> Path:
    """Write `margins.html` and return its path."""
    path = out / "margins.html"
    write_text(path, page(measured))
    return path


def page(measured: Measured) -> str:
    """Return the page of margins as HTML. The content only depends on the margins."""
    result = measured.result
    shown = _replayed(measured)
    replay, events = _replay(measured, shown) if shown else (None, [])
    return render(
        "after/margins/page.html",
        charts={
            "alone": [Chart("Each alone", _tornado(result), "pale: succeeds up to the largest value tried", "rows")],
            "joint": [_histogram(measured)],
        },
        replay=replay,
        events=events,
        title=title(measured.learned),
        result=result,
        tone=result.together.tone,
        rows=range_rows(result),
        worst=[_described(measured, draw) for draw in measured.draws[: 2 * REPLAYED]],
        fold=measured.learned,
        simulated=simulated(result),
        help=HELP,
    )


def _tornado(result: MarginsRecord) -> Plot:
    """Return a chart with one bar for each disturbance.

    The bar goes from the lowest to the highest value at which the fold succeeds, in standard deviations.
    """
    margins = by_sureness(result)[::-1]
    most = 1.0 + max((deviations(margin, margin.tried[1]) for margin in margins), default=1.0)
    names = [channel_of(margin.name).title for margin in margins]
    data = [_bars(margins, names, sign, most) for sign in (-1.0, 1.0)]
    bounds = [line("x", at, colour="@line") for at in (-2.0, 2.0)]
    return traces(
        data,
        barmode="overlay",
        bargap=0.25,
        **rows(names),
        xaxis=axis("standard deviations", range=[-most, most]),
        shapes=[*bounds, line("x", 0.0, dash="solid")],
    )


def _bars(rows: Sequence[AloneMargin], names: list[str], sign: float, most: float) -> dict[str, Any]:
    ends = [margin.low if sign < 0 else margin.high for margin in rows]
    lengths = [min(deviations(margin, end), most) for margin, end in zip(rows, ends, strict=True)]
    place = 0 if sign < 0 else 1
    return {
        "type": "bar",
        "orientation": "h",
        "y": names,
        "x": [round(sign * length, 3) for length in lengths],
        "text": [reach(margin)[place] for margin in rows],
        "textposition": "inside",
        "insidetextanchor": "end",
        "textfont": {"size": 11},
        "constraintext": "none",
        "marker": {"color": ["@line" if end is None else "@plot" for end in ends]},
        "hovertemplate": "%{y}: succeeds to %{text}<extra></extra>",
    }


def _histogram(measured: Measured) -> Chart:
    distances = [1e3 * draw.distance for draw in measured.draws]
    limit = 1e3 * measured.result.limits.mean_vertex_distance
    width = max(0.5, round(limit / 12.0, 1))
    beyond = min(max(distances), 6.0 * limit)
    bins = {"start": 0.0, "end": beyond + width, "size": width}
    shown = [round(min(value, beyond), 3) for value in distances]
    plot = traces(
        [{"type": "histogram", "x": shown, "xbins": bins, "marker": {"color": "@plot"}}],
        xaxis=axis("mean vertex distance [mm]", range=[0.0, max(beyond, 1.2 * limit) + width]),
        yaxis=axis("scenarios"),
        bargap=0.06,
        shapes=[line("x", limit, colour="@failed", dash="dash")],
    )
    return Chart("All at once", plot, caption=f"{len(distances)} scenarios; dashed: the limit.")


def _described(measured: Measured, draw: Draw) -> tuple[int, str, str]:
    """Return a draw's number, a description of its result, and its largest disturbances, for the page."""
    off = {each.name: abs(draw.scenario[each.name] - each.mean) / each.deviation for each in measured.result.alone}
    channels = [channel_of(name) for name in sorted(off, key=lambda name: -off[name])]
    values = [(channel, channel.shown(draw.scenario[channel.name])) for channel in channels[:3]]  # the largest ones
    end = draw.outcome.error or f"{1e3 * draw.distance:.1f} mm, IoU {draw.outcome.mask_iou:.2f}"
    cause = draw.outcome.cause(measured.result.limits)
    if cause is not None and draw.outcome.error is None:
        end = f"{cause}: {end}"
    return draw.number, end, "; ".join(f"{channel.title}: {channel.text(value)}" for channel, value in values)


def _replayed(measured: Measured) -> list[Replayed]:
    """Simulate the worst draws of the disturbances again, and return these simulations.

    Draws whose simulation failed are omitted.
    """
    subject = measured.subject
    worst = [draw for draw in measured.draws if draw.outcome.error is None][:REPLAYED]
    with executor_of(None, REPLAYED if capabilities(subject.task.simulator).parallel else 1) as workers:
        found = list(workers.map(lambda draw: _simulated(subject, draw), worst))
    return [each for each in found if each is not None]


def _simulated(subject: Subject, draw: Draw) -> Replayed | None:
    """Simulate a draw again; None if this fails, though it did not on the machine that simulated it before."""
    try:
        task = subject.task
        scene = disturbed_scene(task.fold, task.manipulation(subject.parameters), draw.scenario)
        return Replayed(draw, scene, simulate(scene, task.simulator))
    except SimulationError:
        return None


def _replay(measured: Measured, shown: Sequence[Replayed]) -> tuple[dict[str, Any], list[tuple[float, str]]]:
    """Return what the viewer needs to replay at least one draw after another, and the marks of its time slider.

    There is a gap of one frame between two draws. A mark has the start of a draw as a fraction of the whole time.
    """
    target, first = measured.subject.task.fold.target, shown[0]
    lengths = [each.rollout.times[-1] + 1.0 / each.scene.frame_rate for each in shown]
    starts = [0.0, *np.cumsum(lengths)[:-1].tolist()]
    times = [each.rollout.times + start for each, start in zip(shown, starts, strict=True)]
    positions = np.concatenate([each.rollout.positions for each in shown])
    joined = Rollout(np.concatenate(times), positions, first.rollout.faces, first.rollout.info, {"target": target})
    scale = largest(np.linalg.norm(first.rollout.positions[-1] - target, axis=1))
    end = float(times[-1][-1])
    marks = [(start / end, f"scenario {each.draw.number}") for each, start in zip(shown, starts, strict=True)]
    return replay_data(joined, first.scene, _hands(shown, starts), scale), marks


def _hands(shown: Sequence[Replayed], starts: Sequence[float]) -> list[HandTrack]:
    """Return the paths of both hands through all replayed draws, which begin at `starts` [s].

    If a hand missed the cloth, the path of the other hand is returned in its place.
    """
    tracks = []
    for hand, colour in zip(HANDS, HAND_COLOURS, strict=True):
        paths = []
        holds: list[tuple[float, float | None]] = []
        for each, start in zip(shown, starts, strict=True):
            own = [gripper for gripper in each.scene.grippers if gripper.hand == hand]
            gripper = next(iter([*own, *each.scene.grippers]), None)  # the hand's first one, or the other hand's
            if gripper is None:
                paths.append(each.rollout.positions[:, 0])
                continue
            grasp = each.scene.cloth.vertices[gripper.vertices].mean(axis=0)
            paths.append(grasp + gripper.path(each.rollout.times))
            holds.append((start + gripper.closes, None if gripper.opens is None else start + gripper.opens))
        tracks.append(HandTrack(colour, np.concatenate(paths), holds))
    return tracks
