"""The page of a rehearsal: the robot and the cloth in one replay, how the fold came out, how the joints followed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.files import write_text
from tatamu.report import tables
from tatamu.report.chart import Figure, axis, layout, line
from tatamu.report.errormap import largest, maps
from tatamu.report.headline import title
from tatamu.report.markup import rows, table, text
from tatamu.report.replay import COLOURS, FRAMES, Hand, replay_of
from tatamu.report.sheet import Sheet, card
from tatamu.report.topview import beside
from tatamu.results import Scores
from tatamu.robots.checks import in_words
from tatamu.robots.links import link_boxes
from tatamu.robots.planned import ARMS
from tatamu.robots.pose import into
from tatamu.robots.refold import Refold
from tatamu.robots.rehearsal import Rehearsal
from tatamu.robots.report import AS_FLOATING, halved
from tatamu.rollout import Rollout

POINTS = 400
"""Most points of a curve."""


def write_page(rehearsal: Rehearsal, figures: dict[str, Any], fold: Refold | None, folder: Path) -> Path:
    """Write `report.html`; `figures` is what rehearsal.json holds. Returns the page."""
    write_text(folder / "report.html", page(rehearsal, figures, fold))
    return folder / "report.html"


def page(rehearsal: Rehearsal, figures: dict[str, Any], fold: Refold | None) -> str:
    """The whole page; the same rehearsal gives the same bytes."""
    good = not rehearsal.contacts and (fold is None or fold.apart.mean() <= AS_FLOATING)
    robot = figures["robot"].upper()
    name = f"{title(fold.learned.fold)}, {robot}" if fold and fold.learned else robot
    sheet = Sheet("a rehearsal", name, _lead(figures), "as planned" if good else "not as planned", good)
    if fold is not None:
        sheet.replay(_replay(rehearsal, fold), _events(rehearsal))
        _fold(sheet, figures["fold"], fold)
    _following(sheet, rehearsal)
    _touching(sheet, rehearsal)
    return sheet.html()


def _lead(figures: dict[str, Any]) -> str:
    fold, contacts = figures["fold"], len(figures["contacts"])
    touched = f"<strong>{contacts} pairs of links touched</strong>" if contacts else "nothing touched that should not"
    said = (
        f"{figures['simulated_seconds']:.1f} s driven in MuJoCo, {figures['real_time_factor']:.0f} times faster than "
        f"real time: tools within {1e3 * figures['tool_error']:.2f}&nbsp;mm of the plan while they hold the cloth, "
        f"{touched}."
    )
    if fold is None:
        return f"{said} No cloth was simulated."
    return (
        f"{said} With the hands as they really moved the cloth ends "
        f"<strong>{1e3 * fold['distance_to_floating_hands']:.1f}&nbsp;mm</strong> on average from where floating hands "
        f"leave it, in {text(str(fold['simulator']))}."
    )


def _replay(rehearsal: Rehearsal, fold: Refold) -> dict[str, Any]:
    """Data of the viewer over the whole motion: cloth and hands in the fold's frame, the robot's links as boxes."""
    closes = rehearsal.closes
    times = np.linspace(0.0, max(rehearsal.times[-1], closes + fold.robot.times[-1]), FRAMES)
    moved = np.clip(np.searchsorted(rehearsal.times, times), 0, len(rehearsal.times) - 1)
    lain = np.clip(np.searchsorted(fold.robot.times, times - closes), 0, len(fold.robot.times) - 1)
    goal = fold.target if fold.target is not None else fold.floating.positions[-1]
    rollout = Rollout(times, fold.robot.positions[lain], fold.robot.faces, {}, {"target": goal})
    tools = into(rehearsal.planned.plan.task_in_base.matrix, rehearsal.tools[:, moved])
    hands = [
        Hand(colour, path, [(rehearsal.planned.event(arm, "close"), rehearsal.planned.event(arm, "open"))])
        for colour, path, arm in zip(COLOURS, tools, ARMS, strict=True)
    ]
    scale = largest(np.linalg.norm(fold.robot.positions[-1] - goal, axis=1))
    return replay_of(rollout, fold.scene, hands, scale, link_boxes(rehearsal.planned, rehearsal.angles[moved]))


def _events(rehearsal: Rehearsal) -> str:
    """Marks under the slider: when the fingers close and open, as HTML."""
    marks = [(rehearsal.planned.event(ARMS[0], name) / rehearsal.times[-1], name) for name in ("close", "open")]
    return "".join(f'<span style="--at:{at:.4f}">{name}</span>' for at, name in marks)


def _fold(sheet: Sheet, figures: dict[str, Any], fold: Refold) -> None:
    mesh = f" on a mesh whose edges were {halved(fold.halvings)}" if fold.halvings else ""
    about = (
        f"By the functions that score learned folds. Robot: the hands as rehearsed, in {text(fold.simulator)}{mesh}. "
        "Floating: hands without a robot that move as they were learned, in the same simulator on the same mesh. "
        "Learned: where the fold was learned."
    )
    if fold.learned is None:
        sheet.section("The fold", about, card("", f"Not scored: {text(fold.unscored or '')}."))
        return
    scores = {name: Scores.model_validate(score) for name, score in figures["scores"].items()}
    warned = "".join(f"<li>{text(str(warning))}</li>" for warning in figures["warnings"])
    sheet.section(
        "The fold",
        about,
        card("", tables.compared(list(scores.items()))),
        f'<ul class="warnings">{warned}</ul>' if warned else "",
    )
    seen = replace(fold.learned.fold, rollout=fold.robot)
    apart = replace(seen, rollout=replace(fold.robot, extra={"target": fold.floating.positions[-1]}))
    about = "Top views; then how far each vertex ends from where floating hands leave it."
    sheet.section(
        "Against floating hands",
        about,
        card("three", beside(seen, fold.learned.fold.target, "The robot’s fold")),
        card("two", [sheet.chart(f"Distance between the two: {name.lower()}", chart) for name, chart in maps(apart)]),
    )


def _following(sheet: Sheet, rehearsal: Rehearsal) -> None:
    every = max(1, len(rehearsal.times) // POINTS)
    times = rehearsal.times[::every]
    joints = {
        name: 1e3 * column
        for name, column in zip(rehearsal.planned.plan.joints, rehearsal.joint_distances[::every].T, strict=True)
        if np.ptp(column) > 1e-6
    }
    tools = dict(zip(ARMS, 1e3 * rehearsal.tool_distances[:, ::every], strict=True))
    marks = [rehearsal.planned.event(ARMS[0], name) for name in ("close", "open")]
    sheet.section(
        "How the robot followed",
        "Each joint less its plan, and each tool’s distance from its plan. Red: the left arm; green: the right. "
        "Dotted: the fingers close and open.",
        card(
            "two",
            [
                sheet.chart("Joints", _curves(times, joints, "off the plan [mrad]", marks)),
                sheet.chart("Tools", _curves(times, tools, "off the plan [mm]", marks)),
            ],
        ),
    )


def _curves(times: np.ndarray, curves: dict[str, np.ndarray], title: str, marks: list[float]) -> Figure:
    colours = {"larm": "@left", "rarm": "@right"}
    return {
        "data": [
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
        "layout": layout(xaxis=axis("time [s]"), yaxis=axis(title), shapes=[line("x", mark) for mark in marks]),
    }


def _touching(sheet: Sheet, rehearsal: Rehearsal) -> None:
    body = [
        f'<tr><th scope="row">{text(" and ".join(contact.links))}</th><td class="number">{contact.first:.2f}</td>'
        f'<td class="number">{1e3 * contact.depth:.1f}</td></tr>'
        for contact in rehearsal.contacts
    ]
    found = table(["links", "first [s]", "depth [mm]"], body) if body else "Nothing touched that should not."
    sheet.section("What touched", "Links against links and the table, among all that the plan checks.", card("", found))
    checks = [
        f'<tr><th scope="row">{text(name.replace("_", " "))}</th><td class="number">{value}</td>'
        f"<td>{text(unit)}</td><td>{limit}</td><td>{'✓' if check.ok else '✗'}</td></tr>"
        for name, check in rehearsal.planned.plan.checks.items()
        for value, unit, limit in [in_words(check.value, check.limit, check.unit, check.ok)]
    ]
    facts = rows(
        [
            ("robot", rehearsal.planned.plan.robot),
            ("driven", f"{rehearsal.times[-1]:.2f} s in {rehearsal.wall_seconds:.2f} s"),
            ("real time factor", f"{rehearsal.real_time_factor:.1f}"),
        ]
    )
    head = ["check", "value", "unit", "limit", ""]
    sheet.section(
        "The plan’s own checks", "From plan.json.", card("", table(head, checks)), card("lists", f"<div>{facts}</div>")
    )
