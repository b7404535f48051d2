"""The command `tatamu margins`, which measures how much error a learned fold tolerates before it fails."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.console import Console

from tatamu.base.errors import InputError
from tatamu.cli.options import SchedulerOption

if TYPE_CHECKING:
    from tatamu.after.margins import Measured
    from tatamu.study.folder import ResultFolder


def margins(
    folder: Path = typer.Argument(
        ..., metavar="DIR", help="Folder of a learned fold, or of a learned plan of several steps."
    ),
    disturbances: str | None = typer.Option(
        None,
        metavar="default|FILE.toml",
        help="Disturbances of hands, cloth and table; default: as in the study, or `default` if the study had none.",
    ),
    draws: int = typer.Option(200, help="Number of scenarios, each with all disturbances at once."),
    seed: int = typer.Option(0, help="Seed of the scenarios."),
    simulator: str | None = typer.Option(
        None, help="Simulator: native, blender or mujoco; default: the simulator of the study."
    ),
    distance: float = typer.Option(0.0125, help="Mean vertex distance [m] above which a fold fails."),
    iou: float = typer.Option(0.80, help="Mask IoU (overlap with the target, 0 to 1) below which a fold fails."),
    out: Path | None = typer.Option(
        None, metavar="OUT", help="Output folder; default: DIR/margins, or DIR/margins-SIMULATOR with --simulator."
    ),
    scheduler: SchedulerOption = None,
) -> None:
    """Measure how large errors of hands, grasps, cloth and table may be before a learned fold fails.

    First, each disturbance is tested alone, in both directions. Then many random draws of all disturbances are tested.

    Examples:
    `tatamu margins runs/towel`

    `tatamu margins runs/towel --disturbances my-robot.toml --draws 500 --seed 1`

    `tatamu margins runs/towel --simulator mujoco --draws 50`

    `tatamu margins runs/towel --distance 0.005`

    Every simulation is kept. To resume an interrupted command, run the same command again.
    """
    from tatamu.api import measure_margins
    from tatamu.cluster import executor_at
    from tatamu.evaluation.disturbances import require_disturbances
    from tatamu.folding.score import Limits
    from tatamu.study.folder import ResultFolder

    given = None if disturbances is None else require_disturbances(disturbances)
    if not 0.0 < distance <= 1.0:
        raise InputError(f"--distance: must be above 0 and at most 1 m, given {distance:g}")
    if not 0.0 <= iou <= 1.0:
        raise InputError(f"--iou: must be from 0 to 1, given {iou:g}")
    limits = Limits(mean_vertex_distance=distance, mask_iou=iou)
    results = ResultFolder(folder)
    steps = results.learned_steps() if results.holds_plan else [results]
    if not steps:
        raise InputError(
            f"{folder}: must contain a learned step, but no step has been learned yet; run `tatamu learn` first"
        )
    if out is not None and len(steps) > 1:
        raise InputError(
            "--out: must be left out for a plan of several steps; to use --out, give the folder of one step"
        )
    with executor_at(scheduler) as executor:
        measure = partial(measure_margins, draws=draws, disturbances=given, seed=seed, limits=limits, executor=executor)
        for step in steps:
            _one(step, measure, out, simulator, prepares=executor is None)


def _one(
    folder: ResultFolder, measure: Callable[..., Measured], out: Path | None, simulator: str | None, *, prepares: bool
) -> None:
    from tatamu.after.margins.page import write_page
    from tatamu.after.margins.texts import summary, table
    from tatamu.cli.progress import prepare, resumable
    from tatamu.report import write_report
    from tatamu.show.progress import progress
    from tatamu.simulation.simulators import require
    from tatamu.study.result import Result

    learned = Result.load(folder.path)
    chosen = simulator or learned.simulator
    require(chosen)
    if prepares:
        prepare(chosen)
    target = out or (folder.margins_folder if simulator is None else folder.path / f"margins-{simulator}")
    kept = f"finished simulations are kept in {target}"
    with resumable(kept), progress(f"margins of {folder.path.name}", unit="simulations") as report:
        measured = measure(
            learned, out=target, simulator=simulator, together=lambda each: print(each.headline), progress=report
        )
    folder.write_margins(measured.result, target)
    page = write_page(measured, target)
    if target == folder.margins_folder:
        write_report(learned)  # the headline shows the new success rate
    Console().print(table(measured.result))
    print(summary(measured.result))
    print(f"margins: {page}")
