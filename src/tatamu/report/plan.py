"""Writes the HTML page of a plan of several steps.

The page has one replay of all steps. It also has the measures of each step, and pictures of each step and its target.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tatamu.base.files import write_text
from tatamu.report import command, topview
from tatamu.report.conclusion import of_plan
from tatamu.report.errormap import largest
from tatamu.report.headline import spelled
from tatamu.report.measures import grade
from tatamu.report.page import file_of, hands
from tatamu.show.page import render
from tatamu.show.replay import HAND_COLOURS, HandTrack, replay_data
from tatamu.simulation.rollout import Rollout
from tatamu.study.plan import PlanResult
from tatamu.study.result import Result


def write_plan_report(whole: PlanResult, file: Path | None = None) -> Path:
    """Write the page of a plan, and return its path.

    Args:
        whole: The learned plan.
        file: File to write; None for `report.html` in the plan's folder.

    Raises:
        InputError: If the file cannot be written, or the plan has no folder and no file is given.
    """
    out = file_of(whole.folder, file)
    write_text(out, page(whole))
    return out


def page(whole: PlanResult) -> str:
    """Return the page of a learned plan as HTML. The same plan always gives the same bytes."""
    result, folds, rollout = whole.record, whole.steps, whole.rollout
    target = rollout.extra["target"]
    final = result.final
    plan = result.plan
    scale = largest(np.linalg.norm(rollout.positions[-1] - target, axis=1))
    views = [(step, topview.beside(fold, fold.target)) for step, fold in zip(result.steps, folds, strict=True)]
    return render(
        "report/plan.html",
        replay=replay_data(rollout, folds[0].scene, _hands(folds, rollout), scale),
        title=f"{spelled(plan.garment)}, {plan.fold}{_count(folds)}",
        verdict=grade(final.mean_vertex_distance),
        # marks under the replay's time slider, as fractions of the whole time: the start of each step
        events=[(float(start / rollout.times[-1]), str(n)) for n, start in enumerate(rollout.extra["step_starts"], 1)],
        result=result,
        final=final,
        conclusion=of_plan(result, [fold.record for fold in folds]),
        trials=sum(step.trials for step in result.steps),
        views=views,
        whole=topview.beside(folds[-1], target),
        learn_command=command.learn(folds[0]),
    )


def _count(folds: list[Result]) -> str:
    """Return the number of folds of a plan as text.

    For an interrupted plan, the text also has the number of folds that were learned.
    """
    step = folds[0].record.task.step
    count = step[1] if step else len(folds)
    return f" in {count} folds" if count == len(folds) else f", the first {len(folds)} of {count} folds"


def _hands(folds: list[Result], rollout: Rollout) -> list[HandTrack]:
    """Return the motion of each hand through all steps. While the cloth settles, a hand moves to its next grasp."""
    starts = rollout.extra["step_starts"]
    found = []
    for number, colour in enumerate(HAND_COLOURS):
        parts = [tracks[number] if number < len(tracks) else None for tracks in map(hands, folds)]
        known = [part for part in parts if part is not None]
        if not known:
            continue
        paths = [
            _onwards(part, fold, parts[at + 1 :]) if part is not None else None
            for at, (part, fold) in enumerate(zip(parts, folds, strict=True))
        ]
        holds = [
            (float(start) + closes, None if opens is None else float(start) + opens)
            for part, start in zip(parts, starts, strict=True)
            if part is not None
            for closes, opens in part.holds
        ]
        found.append(HandTrack(colour, joined_path(paths, folds), holds))
    return found


def _onwards(part: HandTrack, fold: Result, later: list[HandTrack | None]) -> np.ndarray:
    """Return the path of a hand in a step [m], shape (f, 3). After it opens, it rises and moves to its next grasp."""
    opens = part.holds[-1][1]
    goal = next((each.path[0] for each in later if each is not None), None)
    if goal is None or opens is None:
        return part.path
    times = fold.rollout.times
    share = np.clip((times - opens) / max(times[-1] - opens, 1e-9), 0.0, 1.0)
    lift = 0.10
    smooth = (share * share * (3.0 - 2.0 * share))[:, None]
    return part.path + smooth * (goal - part.path[-1]) + np.sin(np.pi * smooth) * [0.0, 0.0, lift]


def joined_path(paths: list[np.ndarray | None], folds: list[Result]) -> np.ndarray:
    """Return the paths of one hand in all steps of a plan, joined to one path [m].

    The path of a step is None if the hand does not grasp in this step. The hand then waits.
    """
    joined: list[np.ndarray] = []
    for path, fold in zip(paths, folds, strict=True):
        frames = len(fold.rollout.times)
        if path is None:
            waits = joined[-1][-1] if joined else next(each[0] for each in paths if each is not None)
            path = np.tile(waits, (frames, 1))
        joined.append(path[1:] if joined else path)
    return np.concatenate(joined)
