"""The command `tatamu rehearse`, which simulates a robot that executes a plan."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import typer


def rehearse(
    plan: Path = typer.Argument(..., metavar="PLAN", help="The folder of a plan."),
    simulator: str = typer.Option(
        "mujoco", help="Simulator of the cloth: native, blender, mujoco, or `none` for no cloth."
    ),
    halvings: int | None = typer.Option(
        None,
        min=0,
        max=3,
        help="How many times the edges of the cloth's mesh are halved; default: as many as the simulator needs.",
    ),
    film: bool = typer.Option(True, help="Also write an animated GIF."),
) -> None:
    """Simulate in MuJoCo how a robot executes a plan, and simulate the cloth that its hands fold.

    Examples:
    `tatamu rehearse runs/hand-towel-plan`

    `tatamu rehearse runs/hand-towel-plan --simulator native`
    """
    if sys.platform == "linux" and "DISPLAY" not in os.environ:
        os.environ.setdefault("MUJOCO_GL", "egl")  # mujoco reads it only when it is imported
    from tatamu.robots.film import save_film
    from tatamu.robots.page import write_page
    from tatamu.robots.planfile import Planned
    from tatamu.robots.refold import refold
    from tatamu.robots.rehearsal import rehearse as rehearsed
    from tatamu.robots.report import save, summary
    from tatamu.show.progress import progress
    from tatamu.simulation.simulators import require

    if simulator != "none":
        require(simulator)
    planned = Planned.load(plan)
    if planned.plan.hover and simulator != "none":
        height = 1e3 * planned.plan.hover
        print(f"no cloth is simulated, because the plan raises the motion by {height:.0f} mm and keeps the jaws open")
        simulator = "none"
    with progress("rehearsing the robot's motion"):
        result = rehearsed(planned)
    with progress(f"simulating the fold in {simulator}: first as the robot moves its hands, then as learned"):
        fold = refold(result, simulator, halvings) if simulator != "none" else None
    if fold is None and simulator != "none":
        print(
            f"warning: no cloth is simulated, because {result.planned.fold.scene_file} is missing; plan a fold whose "
            "folder contains scene.json"
        )
    figures = save(result, plan / "rehearsal", fold)
    for line in summary(figures):
        print(line)
    if film:
        path = plan / "rehearsal" / "film.gif"
        why_not = save_film(result, fold.robot if fold else None, path)
        print(f"warning: the film cannot be drawn ({why_not})" if why_not else f"film: {path}")
    print(f"page: {write_page(result, figures, fold, plan / 'rehearsal')}")
