"""`tatamu learn`: a garment in, a learned fold and its report out."""

from __future__ import annotations

import sys
import warnings
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from tatamu.cli.app import Interrupted, app
from tatamu.cli.cluster import SchedulerOption, StorageOption
from tatamu.cli.learning import LearnOptions, counted, share


@app.command()
def learn(
    garment: Annotated[str, typer.Argument(metavar="GARMENT", help="A name (`tatamu garments`) or a file.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the study; an unfinished one goes on.")],
    size: Annotated[
        str | None, typer.Option(metavar="WxL", help="Width x length in metres, such as 0.34x0.80.")
    ] = None,
    scale: Annotated[
        float | None,
        typer.Option(metavar="M", help="Metres per unit of the garment's file, such as 0.001; default: as it says."),
    ] = None,
    fold: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE.toml",
            help="How to fold it: half; towel: quarters; tshirt: shop; trousers: leg, thirds; a plan of your own; auto "
            "or another that `tatamu plans` lists.",
        ),
    ] = "half",
    hands: Annotated[int | None, typer.Option(help="Fold with 1 hand or 2; default: as the plan says, 2.")] = None,
    material: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.toml", help="A material file, or a preset such as denim; default: the garment's own."
        ),
    ] = None,
    spacing: Annotated[
        float | None, typer.Option(help="Mesh spacing in metres; default: half the bending length, or coarser.")
    ] = None,
    simulator: Annotated[str, typer.Option(help="native, blender or mujoco.")] = "native",
    sampler: Annotated[str, typer.Option(help="How to search: gp, tpe, cmaes, lm or random.")] = "gp",
    grasps: Annotated[
        str, typer.Option(help="Search grasps as integer, or continuous and floored as in the paper.")
    ] = "integer",
    trials: Annotated[
        str,
        typer.Option(
            metavar="N|auto",
            help="Trials of the study in the end; auto: until less than 0.1 % is expected to be gained.",
        ),
    ] = "50",
    seed: Annotated[int, typer.Option(help="Seed of the search.")] = 0,
    parallel: Annotated[
        int | None,
        typer.Option(help="Trials pending at a time, on any number of cores; default: 4. With 1 each knows all."),
    ] = None,
    coarse: Annotated[
        bool | None,
        typer.Option(
            help="Search on a coarser mesh first, and end on the default one (default, where there is one).",
            show_default=False,
        ),
    ] = None,
    disturbances: Annotated[
        str | None,
        typer.Option(
            metavar="default|none|FILE.toml",
            help="Errors of hands, cloth and table that the fold has to tolerate; none: the paper's C. Not given: as "
            "the study began, as the robot's .toml says, or default.",
        ),
    ] = None,
    quantile: Annotated[
        str | None,
        typer.Option(
            metavar="Q|mean",
            help="Minimise this quantile of the objective, in later steps one with half as much beyond it, or its "
            "mean; default: 0.95.",
        ),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(help="Only folds within reach of hironx, nextage, or a .toml that describes a robot."),
    ] = None,
    baselines: Annotated[bool, typer.Option(help="Also score three fixed trajectories.")] = True,
    scheduler: SchedulerOption = None,
    storage: StorageOption = None,
) -> None:
    """Learn to fold a garment: search grasps and hand trajectories in the simulator.

    Examples:
    `tatamu learn towel --out runs/towel`

    `tatamu learn towel --size 0.30x0.50 --trials 20 --seed 1 --out runs/small`

    `tatamu learn towel --trials auto --out runs/quick`

    `tatamu learn towel --disturbances none --out runs/paper`

    `tatamu learn tshirt --fold shop --out runs/shop`

    `tatamu learn trousers --fold leg --hands 1 --out runs/leg`

    `tatamu learn hoodie.svg --fold auto --out runs/hoodie`

    `tatamu learn towel --size 0.30x0.36 --robot hironx --out runs/hand-towel`

    `tatamu learn towel --scheduler tcp://10.0.0.5:8786 --storage postgresql://lab@db/folds --out runs/towel`

    A fold in several steps learns each in turn, in DIR/step-1, DIR/step-2 .., with `--trials` each.
    Run the same command again to go on with a study that was interrupted, or with more `--trials`.
    """
    options = LearnOptions(
        garment=garment,
        size=size,
        scale=scale,
        fold=fold,
        hands=hands,
        material=None if material is None else str(material),
        spacing=spacing,
        simulator=simulator,
        sampler=sampler,
        grasps=grasps,
        trials=counted(trials),
        seed=seed,
        parallel=parallel,
        coarse=coarse,
        disturbances=disturbances,
        quantile=share(quantile),
        robot=robot,
        baselines=baselines,
    )
    with ExitStack() as connections:
        _learn(options, out, scheduler, storage, connections)


def _learn(
    options: LearnOptions, out: Path, scheduler: str | None, storage: str | None, connections: ExitStack
) -> None:
    """Learn, and say what came out; connections stay open until it has ended."""
    from tatamu.cli.progress import LearningDisplay, starting

    with starting(f"laying out {options.garment}"):
        from tatamu.simulators import require

        require(options.simulator)
        from tatamu.cli.verdict import conclusion, how_sure, kept, spoken
        from tatamu.cluster import executor_at
        from tatamu.folding.advice import UncarriedWarning, advice
        from tatamu.folding.baselines import BASELINES
        from tatamu.learning.database import shared_database  # last, as it takes seconds to import

        database = connections.enter_context(shared_database(storage))
        job = options.job(out, database)
        said = advice(job.garment, job.plan, job.hands)
    if job.garment.own:
        print(job.garment.statement)
        for note in job.garment.notes:
            print(f"note: {note}")
    for line in said:
        print(f"warning: {line}", file=sys.stderr)
    warnings.simplefilter("ignore", UncarriedWarning)  # said already
    fixed = len(BASELINES) if options.baselines else 0
    try:
        with (
            executor_at(scheduler) as executor,
            LearningDisplay(job, options.most_trials, fixed, prepares=executor is None) as display,
        ):
            report = options.learn(job, out, display.reporting, executor, database)
    except KeyboardInterrupt:
        raise Interrupted(kept(out)) from None
    for line in how_sure(out):
        print(line)
    for line in spoken(conclusion(out)):
        print(line)
    print(f"report: {report}")
