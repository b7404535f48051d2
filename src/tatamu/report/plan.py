"""The page of a plan of several steps: all steps in one replay, their measures, each beside its target."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tatamu import __version__
from tatamu.files import write_text
from tatamu.report import command, topview
from tatamu.report.errormap import largest
from tatamu.report.headline import spelled
from tatamu.report.markup import filled, inline, table, text
from tatamu.report.page import frame, resource
from tatamu.report.replay import COLOURS, Hand, hands, replay_of
from tatamu.report.verdict import grade
from tatamu.results import LearnedFold, PlanResult, StepResult, read_fold
from tatamu.rollout import Rollout

LIFT = 0.10
"""How far the hands rise on their way to the next grasp, in the replay [m]."""
COLUMNS: tuple[tuple[str, Callable[[StepResult], str]], ...] = (
    ("mean distance [mm]", lambda step: f"{1e3 * step.mean_vertex_distance:.1f}"),
    ("mask IoU", lambda step: f"{step.mask_iou:.3f}"),
    ("E<sub>f</sub> [%]", lambda step: f"{step.area_error:.2f}"),
    ("slip [mm]", lambda step: f"{1e3 * step.slip:.1f}"),
    ("residual bend [mm]", lambda step: f"{1e3 * step.residual_bend:.1f}"),
    ("crossings, end (most)", lambda step: f"{step.crossings.final} ({step.crossings.most})"),
    ("trials", lambda step: str(step.trials)),
    ("from flat: mean distance [mm]", lambda step: f"{1e3 * step.whole.mean_vertex_distance:.1f}"),
    ("from flat: mask IoU", lambda step: f"{step.whole.mask_iou:.3f}"),
)


def write_plan_report(folder: Path, result: PlanResult) -> Path:
    """Write `report.html` of a plan; `rollout.npz` and the steps are there.

    Raises:
        InputError: A step's folder does not hold a learned fold.
    """
    folds = [read_fold(folder / step.folder) for step in result.steps]
    rollout = Rollout.load(folder / "rollout.npz")
    write_text(folder / "report.html", page(folder, result, folds, rollout))
    return folder / "report.html"


def page(folder: Path, result: PlanResult, folds: list[LearnedFold], rollout: Rollout) -> str:
    """The whole page; the same plan gives the same bytes."""
    target, final = rollout.extra["target"], result.final
    verdict = grade(final.mean_vertex_distance)
    scale = largest(np.linalg.norm(rollout.positions[-1] - target, axis=1))
    plan = result.plan
    parts = {
        **frame(_events(result, rollout)),
        "title": text(f"{spelled(plan.garment)}, {plan.fold} in {len(folds)} folds"),
        "verdict": verdict,
        "verdict_class": verdict.replace(" ", "-"),
        "sentence": _sentence(result),
        "steps": _steps(result),
        "figures": "".join(_figures(step, fold) for step, fold in zip(result.steps, folds, strict=True))
        + _section("From the flat garment", "The ideal of all folds of the flat garment.", folds[-1], target),
        "learn_command": text(command.learn(folds[0])),
        "version": text(__version__),
        "replay_data": inline(replay_of(rollout, folds[0].scene, _hands(folds, rollout), scale)),
    }
    return filled(resource("plan.html"), parts)


def _sentence(result: PlanResult) -> str:
    final = result.final
    trials = sum(step.trials for step in result.steps)
    return (
        f"After all folds the garment lies <strong>{1e3 * final.mean_vertex_distance:.1f}&nbsp;mm</strong> on "
        f"average from where ideal folds of the flat garment would have laid it; seen from above the two overlap by "
        f"<strong>{final.mask_iou:.3f}</strong> (IoU). Found in {trials} trials and {result.wall_seconds:.0f} s."
    )


def _events(result: PlanResult, rollout: Rollout) -> str:
    """Marks under the time slider: where each step begins, as HTML."""
    places = rollout.extra["step_starts"] / rollout.times[-1]
    marks = (f'<span style="--at:{place:.4f}">{number}</span>' for number, place in enumerate(places, start=1))
    return "".join(marks)


def _steps(result: PlanResult) -> str:
    head = ["step", *(name for name, _ in COLUMNS)]
    body = []
    for number, step in enumerate(result.steps, start=1):
        hands = ", one hand" if step.hands == 1 else ""
        link = f'<a href="{step.folder}/report.html">{number}. {text(step.title or "fold")}</a>{hands}'
        cells = "".join(f'<td class="number">{show(step)}</td>' for _, show in COLUMNS)
        body.append(f'<tr><th scope="row">{link}</th>{cells}</tr>')
    return table(head, body)


def _figures(step: StepResult, fold: LearnedFold) -> str:
    number = step.folder.removeprefix("step-")
    return _section(
        f"{number}. {step.title or 'Fold'}", "The ideal fold of the state before this step.", fold, fold.target
    )


def _section(title: str, about: str, fold: LearnedFold, goal: np.ndarray) -> str:
    return (
        f'<section><h2>{text(title)}</h2><p class="about">Target: {text(about)}</p>'
        f'<div class="card three">{topview.beside(fold, goal)}</div></section>'
    )


def _hands(folds: list[LearnedFold], rollout: Rollout) -> list[Hand]:
    """The hands through all steps; while the cloth settles they go to their next grasp."""
    starts = rollout.extra["step_starts"]
    found = []
    for number, colour in enumerate(COLOURS):
        parts = [_hand(fold, number) for fold in folds]
        known = [part for part in parts if part is not None]
        if not known:
            continue
        paths = [
            _onwards(part, fold, _next(parts[at + 1 :])) if part is not None else None
            for at, (part, fold) in enumerate(zip(parts, folds, strict=True))
        ]
        holds = [
            (float(start) + closes, None if opens is None else float(start) + opens)
            for part, start in zip(parts, starts, strict=True)
            if part is not None
            for closes, opens in part.holds
        ]
        found.append(Hand(colour, joined_path(paths, folds), holds))
    return found


def _hand(fold: LearnedFold, number: int) -> Hand | None:
    known = hands(fold)
    return known[number] if number < len(known) else None


def _next(parts: list[Hand | None]) -> np.ndarray | None:
    """Where a hand grasps next [m], shape (3,)."""
    return next((part.path[0] for part in parts if part is not None), None)


def _onwards(part: Hand, fold: LearnedFold, goal: np.ndarray | None) -> np.ndarray:
    """The path of a hand [m], shape (f, 3), that after opening goes on to its next grasp."""
    opens = part.holds[-1][1]
    if goal is None or opens is None:
        return part.path
    times = fold.rollout.times
    share = np.clip((times - opens) / max(times[-1] - opens, 1e-9), 0.0, 1.0)
    smooth = (share * share * (3.0 - 2.0 * share))[:, None]
    return part.path + smooth * (goal - part.path[-1]) + np.sin(np.pi * smooth) * [0.0, 0.0, LIFT]


def joined_path(paths: list[np.ndarray | None], folds: list[LearnedFold]) -> np.ndarray:
    """The paths of all steps as one [m]; a hand that does not work in a step waits."""
    joined: list[np.ndarray] = []
    for path, fold in zip(paths, folds, strict=True):
        frames = len(fold.rollout.times)
        if path is None:
            waits = joined[-1][-1] if joined else _next_start(paths)
            path = np.tile(waits, (frames, 1))
        joined.append(path[1:] if joined else path)
    return np.concatenate(joined)


def _next_start(paths: list[np.ndarray | None]) -> np.ndarray:
    return next(path[0] for path in paths if path is not None)
