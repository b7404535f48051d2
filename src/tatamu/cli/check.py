"""The command `tatamu check`, which simulates a learned fold in another simulator."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from tatamu.base.errors import InputError
from tatamu.cli.app import app
from tatamu.cli.cluster import SchedulerOption

if TYPE_CHECKING:
    from tatamu.folding.score import Score
    from tatamu.study.result import Result


@app.command()
def check(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a learned fold.")],
    simulator: Annotated[str | None, typer.Option(help="Other simulator: native, blender or mujoco.")] = None,
    material: Annotated[
        Path | None,
        typer.Option(metavar="FILE.toml", help="Material of the cloth in that simulator; default: the same."),
    ] = None,
    halve: Annotated[bool, typer.Option("--halve", help="Simulate on a mesh of half the spacing.")] = False,
    everything: Annotated[
        bool, typer.Option("--all", help="Compare simulators over the learned fold, baselines and random ones.")
    ] = False,
    simulators: Annotated[
        str, typer.Option(metavar="NAME,..", help="With --all: names of the simulators.")
    ] = "native,blender,mujoco",
    count: Annotated[int, typer.Option("--random", help="With --all: number of random manipulations.")] = 10,
    seed: Annotated[int, typer.Option(help="With --all: seed of the random manipulations.")] = 0,
    out: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Output folder; default: DIR/check-SIMULATOR or DIR/check-all.")
    ] = None,
    scheduler: SchedulerOption = None,
) -> int:
    """Simulate a learned fold again in another simulator, and report whether the fold succeeds there too.

    The exit code is 0 if the fold meets the thresholds of success (mean vertex distance, mask IoU), otherwise 1.

    Examples:
    `tatamu check runs/towel --simulator mujoco`

    `tatamu check runs/towel --simulator blender --material my-towel.toml`

    `tatamu check runs/towel --all --simulators native,mujoco --random 10`

    With `--all`, every simulation is kept. To resume an interrupted command, run the same command again.
    """
    from tatamu.cli.progress import prepare
    from tatamu.simulation.simulators import require
    from tatamu.study.result import Result

    if everything == (simulator is not None):
        raise InputError("check: give either --simulator or --all")
    if everything and material is not None:
        raise InputError("--material: is for one --simulator, not for --all")
    if not everything and scheduler is not None:
        raise InputError("--scheduler: is for --all")
    if not 0 <= count <= 1000:
        raise InputError(f"--random: must be from 0 to 1000, given {count}")
    if seed < 0:
        raise InputError(f"--seed: must be 0 or more, given {seed}")
    names = [simulator] if simulator else [name.strip() for name in simulators.split(",") if name.strip()]
    require(*names)
    learned = Result.load(folder)
    for name in names if scheduler is None else ():
        prepare(name)
    if simulator is None:
        return _all(learned, names, out or folder / "check-all", count, seed, halve, scheduler)
    return _one(learned, simulator, out or folder / f"check-{simulator}", material, halve)


def _one(learned: Result, simulator: str, out: Path, material: Path | None, halve: bool) -> int:
    from tatamu.after.second_opinion.check import check as run
    from tatamu.after.second_opinion.page import save
    from tatamu.simulation.material import load_material

    given = load_material(material) if material else None
    with Console().status(f"{learned.name} in {simulator}"):
        opinion = run(learned, simulator, given, halve)
    page = save(opinion, out)
    here = learned.score
    print(f"{learned.simulator}: {_words(here)}")
    if opinion.score is None:
        print(f"{simulator}: {opinion.error}")
    else:
        print(f"{simulator}: {_words(opinion.score)}; {1e3 * opinion.apart.mean():.1f} mm from {learned.simulator}'s")
    print(f"the fold {'holds' if opinion.holds else 'does not hold'} in {simulator}: {page}")
    return 0 if opinion.holds else 1


def _words(score: Score) -> str:
    distance = 1e3 * score.mean_vertex_distance
    return f"{distance:.1f} mm from the target, IoU {score.mask_iou:.3f}, C = {score.objective:.4f}"


def _all(
    learned: Result, names: list[str], out: Path, count: int, seed: int, halve: bool, scheduler: str | None
) -> int:
    from tatamu.after.second_opinion.agreement import compare
    from tatamu.after.second_opinion.matrix import save, terminal
    from tatamu.cluster import executor_at
    from tatamu.folding.baselines import BASELINES

    console = Console()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with executor_at(scheduler) as executor, Progress(*columns, console=console, transient=True) as bar:
        line = bar.add_task("", total=len(names) * (1 + len(BASELINES) + count))
        begun = iter([0])

        def before(manipulation: str, simulator: str) -> None:
            bar.update(line, description=f"{manipulation} in {simulator}", advance=next(begun, 1))
            if not console.is_terminal:
                console.print(f"{manipulation} in {simulator}")

        agreement = compare(
            learned, names, out, count=count, seed=seed, halved=halve, progress=before, executor=executor
        )
    page = save(agreement, out)
    console.print(terminal(agreement))
    print(f"the learned fold {'holds' if agreement.holds else 'does not hold'} in all of them: {page}")
    return 0 if agreement.holds else 1
