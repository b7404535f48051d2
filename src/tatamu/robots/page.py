"""The page of a rehearsal: a replay of robot and cloth, the result of the fold, and the errors of the joints."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.files import write_text
from tatamu.folding.score import Score
from tatamu.report.errormap import largest, maps
from tatamu.report.headline import title
from tatamu.report.measures import MEASURES
from tatamu.report.tables import Column
from tatamu.report.topview import TopView, beside
from tatamu.robots.checks import in_words
from tatamu.robots.pose import into
from tatamu.robots.refold import Refold
from tatamu.robots.rehearsal import Rehearsal
from tatamu.robots.report import AS_FLOATING, as_planned, halved
from tatamu.robots.stage import link_boxes
from tatamu.show.chart import Chart, Plot, axis, line, traces
from tatamu.show.page import render
from tatamu.show.replay import FRAMES, HAND_COLOURS, HandTrack, replay_data
from tatamu.simulation.rollout import Rollout


def write_page(rehearsal: Rehearsal, figures: dict[str, Any], fold: Refold | None, folder: Path) -> Path:
    """Write `report.html` and return its path; `figures` has the contents of rehearsal.json."""
    write_text(folder / "report.html", page(rehearsal, figures, fold))
    return folder / "report.html"


def page(rehearsal: Rehearsal, figures: dict[str, Any], fold: Refold | None) -> str:
    """Return the whole page. The same rehearsal gives the same bytes."""
    robot = figures["robot"].upper()
    return render(
        "robots/page.html",
        charts={"apart": _apart(fold), "following": _following(rehearsal)},
        replay=_replay(rehearsal, fold) if fold else None,
        title=f"{title(fold.learned)}, {robot}" if fold and fold.learned else robot,
        good=as_planned(figures) and (fold is None or fold.apart.mean() <= AS_FLOATING),
        events=[(time / rehearsal.times[-1], name) for name, time in _marks(rehearsal).items()],
        figures=figures,
        fold=fold,
        mesh=halved(fold.halvings) if fold and fold.halvings else "",
        columns=[
            Column(name, Score.model_validate(score))
            for name, score in (figures["fold"]["scores"] if figures["fold"] else {}).items()
        ],
        measures=MEASURES,
        views=_views(fold),
        rehearsal=rehearsal,
        checks=[
            (name.replace("_", " "), *in_words(check.value, check.limit, check.unit, check.ok), check.ok)
            for name, check in rehearsal.planned.plan.checks.items()
        ],
        facts=[
            ("robot", rehearsal.planned.plan.robot),
            ("driven", f"{rehearsal.times[-1]:.2f} s in {rehearsal.wall_seconds:.2f} s"),
            ("real time factor", f"{rehearsal.real_time_factor:.1f}"),
        ],
    )


def _views(fold: Refold | None) -> list[TopView]:
    if fold is None or fold.learned is None:
        return []
    learned = fold.learned
    return beside(replace(learned, rollout=fold.robot), learned.target, "The robot’s fold")


def _apart(fold: Refold | None) -> list[Chart]:
    """Return charts of the distance of each vertex between two final shapes."""
    if fold is None or fold.learned is None:
        return []
    floating = replace(fold.robot, extra={"target": fold.floating.positions[-1]})
    return [
        replace(chart, title=f"Distance between the two: {chart.title.lower()}")
        for chart in maps(replace(fold.learned, rollout=floating))
    ]


def _replay(rehearsal: Rehearsal, fold: Refold) -> dict[str, Any]:
    """Return the data with which the page's viewer shows the whole motion."""
    closes = rehearsal.closes
    times = np.linspace(0.0, max(rehearsal.times[-1], closes + fold.robot.times[-1]), FRAMES)
    moved = np.clip(np.searchsorted(rehearsal.times, times), 0, len(rehearsal.times) - 1)
    lain = np.clip(np.searchsorted(fold.robot.times, times - closes), 0, len(fold.robot.times) - 1)
    goal = fold.target if fold.target is not None else fold.floating.positions[-1]
    rollout = Rollout(times, fold.robot.positions[lain], fold.robot.faces, {}, {"target": goal})
    tools = into(rehearsal.planned.plan.task_in_base.matrix, rehearsal.tools[:, moved])
    hands = [
        HandTrack(colour, path, [(rehearsal.planned.event(arm, "close"), rehearsal.planned.event(arm, "open"))])
        for colour, path, arm in zip(HAND_COLOURS, tools, rehearsal.planned.arms, strict=False)
    ]
    scale = largest(np.linalg.norm(fold.robot.positions[-1] - goal, axis=1))
    return replay_data(rollout, fold.scene, hands, scale, link_boxes(rehearsal.planned, rehearsal.angles[moved], times))


def _marks(rehearsal: Rehearsal) -> dict[str, float]:
    """Return the times of the events that are marked [s], by their names."""
    return {name: rehearsal.planned.event(rehearsal.planned.arms[0], name) for name in ("close", "open")}


def _following(rehearsal: Rehearsal) -> list[Chart]:
    every = max(1, len(rehearsal.times) // 400)  # about as many points in a curve
    times = rehearsal.times[::every]
    joints = {
        name: 1e3 * column
        for name, column in zip(rehearsal.planned.plan.joints, rehearsal.joint_distances[::every].T, strict=True)
        if np.ptp(column) > 1e-6
    }
    tools = dict(zip(rehearsal.planned.arms, 1e3 * rehearsal.tool_distances[:, ::every], strict=True))
    marks = list(_marks(rehearsal).values())
    return [
        Chart("Joints", _curves(times, joints, "off the plan [mrad]", marks)),
        Chart("Tools", _curves(times, tools, "off the plan [mm]", marks)),
    ]


def _curves(times: np.ndarray, curves: dict[str, np.ndarray], label: str, marks: list[float]) -> Plot:
    colours = {"larm": "@left", "rarm": "@right"}
    return traces(
        [
            {
                "name": name,
                "x": times.round(3).tolist(),
                "y": values.round(4).tolist(),
                "mode": "lines",
                "line": {"width": 1.2, "color": colours.get(name[:4].lower(), "@plot")},
                "hovertemplate": f"{name}<br>%{{x:.2f}} s, %{{y:.3f}}<extra></extra>",
            }
            for name, values in curves.items()
        ],
        xaxis=axis("time [s]"),
        yaxis=axis(label),
        shapes=[line("x", mark) for mark in marks],
    )
