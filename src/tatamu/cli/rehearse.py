"""`tatamu rehearse`: a robot plan in, what happens when the robot does it out."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from tatamu.cli.app import app


@app.command()
def rehearse(
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="The folder of a plan.")],
    simulator: Annotated[
        str, typer.Option(help="Which simulator folds the cloth with the robot's hands; `none`: no cloth.")
    ] = "mujoco",
    film: Annotated[bool, typer.Option(help="Write an animated GIF too.")] = True,
) -> None:
    """Drive a robot through a plan in MuJoCo, and fold the cloth with its hands.

    Example: `tatamu rehearse runs/towel-plan`
    """
    if sys.platform == "linux" and "DISPLAY" not in os.environ:
        os.environ.setdefault("MUJOCO_GL", "egl")  # read once, when mujoco is imported
    from tatamu.robots.film import save_film
    from tatamu.robots.planned import Planned, fold_file
    from tatamu.robots.rehearsal import rehearse as rehearsed
    from tatamu.robots.report import save, summary

    result = rehearsed(Planned.load(plan))
    fold = None
    scene_file = fold_file(plan, "scene.json")
    if simulator != "none" and scene_file is not None:
        from tatamu.rollout import Rollout
        from tatamu.scene import Scene
        from tatamu.simulators import simulate

        learned = Scene.load(scene_file)
        rollout_file = fold_file(plan, "rollout.npz")
        target = Rollout.load(rollout_file).extra.get("target") if rollout_file else None
        scene = result.scene(learned)
        fold = scene, simulate(scene, simulator=simulator), simulate(learned, simulator=simulator), target
    for line in summary(save(result, plan / "rehearsal", fold)):
        print(line)
    if film:
        path = plan / "rehearsal" / "film.gif"
        why_not = save_film(result, fold[1] if fold else None, path)
        print(f"warning: no film: {why_not}" if why_not else f"film: {path}")
