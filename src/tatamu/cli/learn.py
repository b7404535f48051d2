"""`tatamu learn`: a garment in, a learned fold and its report out."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tatamu.cli.app import app
from tatamu.cli.size import parse_size
from tatamu.errors import InputError

if TYPE_CHECKING:
    from tatamu.folding.task import Reach
    from tatamu.learning import Expectation
    from tatamu.learning.schedule import Trials
    from tatamu.material import Material


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
    sampler: Annotated[str, typer.Option(help="How to search: gp, tpe or random.")] = "gp",
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
            help="What is not known of hands, cloth and table, and the fold is to stand; none: the paper's C.",
        ),
    ] = None,
    quantile: Annotated[
        float | None, typer.Option(help="Minimise this quantile of the objective, such as 0.9, instead of its mean.")
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(help="Only folds within reach of hironx, nextage, or a .toml that describes a robot."),
    ] = None,
    baselines: Annotated[bool, typer.Option(help="Also score three fixed trajectories.")] = True,
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

    A fold in several steps learns each in turn, in DIR/step-1, DIR/step-2 .., with `--trials` each.
    Run the same command again to go on with a study that was interrupted, or with more `--trials`.
    """
    from tatamu.folding.task import make_job
    from tatamu.material import load_material

    if grasps not in ("integer", "continuous"):
        raise InputError(f"grasps: must be integer or continuous, given {grasps!r}")
    if hands not in (None, 1, 2):
        raise InputError(f"hands: must be 1 or 2, given {hands}")
    job = make_job(
        garment,
        size=None if size is None else parse_size(size),
        scale=scale,
        fold=fold,
        material=load_material(material) if material else None,
        spacing=spacing,
        simulator=simulator,
        hands=hands,
        reach=_reach(robot),
    )
    if job.garment.own:
        print(job.garment.statement)
        for note in job.garment.notes:
            print(f"note: {note}")
    from tatamu.cli.progress import reporting
    from tatamu.folding.advice import UncarriedWarning, advice
    from tatamu.learning import learn_job  # last, as it takes seconds to import

    for line in advice(job.garment, job.plan, job.hands):
        print(f"warning: {line}", file=sys.stderr)
    warnings.simplefilter("ignore", UncarriedWarning)  # said already
    report = learn_job(
        job,
        out,
        trials=_trials(trials),
        seed=seed,
        sampler=sampler,
        grasps=grasps,  # type: ignore[arg-type]
        baselines=baselines,
        parallel=parallel,
        coarse=coarse,
        expectation=_expectation(out, disturbances, quantile, material, job.garment.material),
        reporting=reporting,
    )
    _say_how_sure(out)
    print(f"report: {report}")


def _say_how_sure(folder: Path) -> None:
    """Print in how many worlds each learned fold holds, where that is known."""
    from tatamu.results import ResultFolder

    results = ResultFolder(folder)
    steps = results.learned_steps() if results.holds_plan else [results]
    for step in steps:
        if step.result.judged is not None:
            name = f"{step.path.name}: " if results.holds_plan else ""
            print(f"{name}{step.result.judged.headline}; `tatamu margins {folder}` asks more")


def _expectation(
    folder: Path, given: str | None, quantile: float | None, file: Path | None, material: Material
) -> Expectation | None:
    """The expectation of the study: as it began, or as given, a calibrated material with its own uncertainties."""
    from tatamu.disturbances import load_disturbances, with_calibrated
    from tatamu.learning import Expectation, as_begun

    begun, held = as_begun(folder)
    if begun and given is None and quantile is None:
        return held
    chosen = load_disturbances(given or "default")
    if chosen is None:
        if quantile is not None:
            raise InputError(
                "quantile: is of the objective in disturbed worlds; with --disturbances none there are none"
            )
        return None
    return Expectation(chosen if file is None else with_calibrated(chosen, file, material), quantile)


def _trials(given: str) -> Trials:
    """A number of trials, or auto."""
    if given == "auto":
        return "auto"
    try:
        return int(given)
    except ValueError:
        raise InputError(f"trials: must be a whole number or auto, given {given!r}") from None


def _reach(robot: str | None) -> Reach | None:
    """The reach constraint of the robot of that name."""
    if robot is None:
        return None
    from tatamu.folding.task import Reach
    from tatamu.robots import ReachConstraint, load

    loaded = load(robot)
    constraint = ReachConstraint(loaded)
    description = Path(robot).read_bytes() if robot.endswith(".toml") else b""
    return Reach(loaded.name, constraint, constraint.refusal, description=description)
