"""What fingers that are bodies change in learned folds, and what they cost: the tables of docs/notes/fingers.md.

    python benchmarks/fingers.py --out runs/fingers [--only "towel half"] [--write-docs]

A towel in half, a T-shirt in half and trousers leg over leg are learned on coarse meshes with bare hands and with
fingers of 15.2 mm: with least C, and in the default disturbed worlds. Every fold is then drawn in worlds in which it
was not learned. Folds of bare hands are also simulated with fingers that they did not have: that is what an older fold
comes to. What was learned is kept in the folder and not learned again.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import process_time, thread_time
from typing import Any

import numpy as np

from benchmarks.tables import IMAGES, markdown, merged, publish, published
from tatamu.after.margins import measure
from tatamu.api import learn
from tatamu.evaluation import Nominal
from tatamu.evaluation.disturbances import default_disturbances
from tatamu.folding.fingers import Fingers
from tatamu.folding.parameters import arched_curve
from tatamu.folding.score import Limits, score
from tatamu.folding.task import Task, make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.report.still import scene_picture
from tatamu.show.image import save_png
from tatamu.simulation.simulators import simulate
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

GARMENTS: dict[str, dict[str, Any]] = {
    "towel half": {"garment": "towel", "fold": "half", "spacing": 0.03},
    "T-shirt half": {"garment": "tshirt", "fold": "half", "spacing": 0.035},
    "trousers leg": {"garment": "trousers", "fold": "leg", "spacing": 0.025},
}
COSTS: dict[str, dict[str, Any]] = {
    **GARMENTS,
    "limp towel half": {**GARMENTS["towel half"], "material": "jersey"},
    "towel half, default mesh": {"garment": "towel", "fold": "half"},
    "T-shirt half, default mesh": {"garment": "tshirt", "fold": "half"},
}
"""Garments whose simulations are timed."""
HANDS = {
    "bare": Fingers(),
    "8 mm": Fingers(thickness=0.008, width=0.022, length=0.0375),
    "15.2 mm": Fingers.of_hand("franka-hand"),
}
LEARNED = ("bare", "15.2 mm")
"""Hands with which folds are learned."""
TRIALS, DRAWS = 12, 12
"""Trials of a study, and draws that judge its fold."""
REPEATS = 3
"""Number of times that a simulation is timed; the fastest counts."""


def learned(name: str, hand: str, robust: bool, out: Path) -> Result:
    """Learn a fold, or read it from the folder."""
    task = make_task(**GARMENTS[name], fingers=HANDS[hand])
    options = LearnOptions(
        trials=TRIALS,
        coarse=False,
        baselines=False,
        disturbances=default_disturbances() if robust else "none",
        seed=0,
    )
    folder = out / f"{name}-{hand}-{'robust' if robust else 'least'}".replace(" ", "-")
    found = learn(task, options, out=folder)
    if not isinstance(found, Result):
        raise SystemExit(f"{folder}: must be one fold")
    return found


def outcome(task: Task, result: Result) -> str:
    """Where a fold ends with the hands of a task: mean distance of the whole and of the moving part [mm]."""
    found = Nominal(task)(result.best.parameters)
    if found.score is None:
        return found.error or "failed"
    moving = found.score.moving_vertex_distance or 0.0
    held = "" if Limits().hold(found.score) else ", fails"
    return f"{1e3 * found.score.mean_vertex_distance:.1f} / {1e3 * moving:.1f}{held}"


def rows(name: str, out: Path) -> Iterator[dict[str, str]]:
    """Return the folds of a garment."""
    for robust in (False, True):
        for hand in LEARNED:
            result = learned(name, hand, robust, out)
            own = HANDS[hand]
            drawn = measure(
                result,
                default_disturbances(),
                out=out / "drawn" / f"{name}-{hand}-{robust}".replace(" ", "-"),
                draws=DRAWS,
                seed=1,
                fine=True,
                alone=False,
            )
            joint = drawn.result.joint
            others = {
                f"with {other} [mm]": outcome(replace(result.task, fingers=fingers), result) if not own.stated else "-"
                for other, fingers in HANDS.items()
                if fingers.stated
            }
            yield {
                "fold": name,
                "learned": "in disturbed worlds" if robust else "least C",
                "fingers": hand,
                "C": f"{result.score.objective:.3f}",
                "path [m]": f"{result.score.trajectory_length:.3f}",
                "whole / moving part [mm]": outcome(result.task, result),
                **others,
                "holds in": f"{joint.held} of {joint.draws}",
                "no fold": drawn.result.reasons or "-",
            }


def costs(name: str) -> dict[str, str]:
    """Processor time of one simulation of the same curve, with each hand."""
    seconds = {}
    for hand, fingers in HANDS.items():
        task = make_task(**COSTS[name], fingers=fingers)
        space = task.space
        scene = scene_of(task.fold, task.manipulation({**space.middle(), "g1": 0, "g2": 0}))
        times = []
        for _ in range(REPEATS + 1):
            started = thread_time()
            final = simulate(scene).positions[-1]
            times.append(thread_time() - started)
        seconds[hand] = min(times[1:])
        score(task.fold, 0.0, final)
    bare = seconds["bare"]
    return {
        "fold": name,
        "bare [s]": f"{bare:.2f}",
        **{f"{hand}, times bare": f"{seconds[hand] / bare:.2f}" for hand in HANDS if hand != "bare"},
    }


def low_hands() -> dict[str, str]:
    """In how many of many default worlds a hand fails whatever the cloth does, without any simulation."""
    from collections import Counter

    from tatamu.evaluation.disturbances import Stream, hand_failure, sample_worlds

    counts: Counter[str] = Counter()
    task = make_task(**GARMENTS["towel half"])
    manipulation = task.manipulation({**task.space.middle(), "g1": 1, "g2": 1})
    worlds = sample_worlds(default_disturbances(), 2000, 1, Stream.MARGINS)
    for world in worlds:
        why = hand_failure(task.fold, manipulation, world)
        counts["neither" if why is None else why.split(":")[0].replace("left ", "").replace("right ", "")] += 1
    return {reason: f"{100 * count / len(worlds):.1f} %" for reason, count in sorted(counts.items())}


def draw(path: Path) -> None:
    """Draw fingers that begin to open: the lower ones lie inside the turned hem."""
    task = make_task(**GARMENTS["towel half"], fingers=HANDS["15.2 mm"])
    manipulation = task.manipulation(arched_curve(task.fold))
    scene = scene_of(task.fold, manipulation)
    rollout = simulate(scene)
    frame = int(np.searchsorted(rollout.times, manipulation.timing.opens + 0.05))
    save_png(scene_picture(scene, rollout, frame), path)


def main() -> None:
    """Print the tables; with --write-docs, write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("runs/fingers"))
    parser.add_argument("--only", choices=sorted(GARMENTS))
    parser.add_argument("--write-docs", action="store_true")
    given = parser.parse_args()
    started = process_time()
    found = {
        "fingers: folds": [row for name in ([given.only] if given.only else GARMENTS) for row in rows(name, given.out)]
    }
    if not given.only:
        found |= {"fingers: cost": [costs(name) for name in COSTS], "fingers: hands": [low_hands()]}
    for table, lines in found.items():
        if given.only:
            lines = merged(published(table), lines, "fold", "learned", "fingers")
        print(f"{table}\n\n{markdown(lines)}\n")
        if given.write_docs:
            publish(table, markdown(lines))
    if given.write_docs:
        draw(IMAGES / "fingers.png")
    print(f"{process_time() - started:.0f} s of processor time")


if __name__ == "__main__":
    main()
