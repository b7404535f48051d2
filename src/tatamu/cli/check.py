"""The command `tatamu check`, which simulates a learned fold in another simulator."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tatamu.base.errors import InputError

if TYPE_CHECKING:
    from tatamu.folding.score import Score


def check(
    folder: Path = typer.Argument(..., metavar="DIR", help="The folder of a learned fold."),
    simulator: str = typer.Option("", help="Simulator for this check: native, blender or mujoco."),
    material: Path | None = typer.Option(
        None,
        metavar="FILE.toml",
        help="Material of the cloth in the other simulator; default: the material of the fold.",
    ),
    halve: bool = typer.Option(False, "--halve", help="Simulate with half the mesh spacing."),
    out: Path | None = typer.Option(None, metavar="OUT", help="Output folder; default: DIR/check-SIMULATOR."),
    everything: bool = typer.Option(False, "--all", hidden=True),
    former: list[str] | None = typer.Option(None, "--simulators", "--random", "--seed", "--scheduler", hidden=True),
) -> int:
    """Simulate a learned fold again in another simulator, and report whether the fold succeeds there too.

    The exit code is 0 if the fold meets the thresholds of success (mean vertex distance, mask IoU), otherwise 1.

    Examples:
    `tatamu check runs/towel --simulator mujoco`

    `tatamu check runs/towel --simulator blender --material my-towel.toml`
    """
    from tatamu.after.second_opinion.page import save
    from tatamu.api import check as run
    from tatamu.cli.progress import prepare
    from tatamu.show.progress import progress
    from tatamu.simulation.material import load_material
    from tatamu.simulation.simulators import require
    from tatamu.study.result import Result

    if everything or former:
        raise InputError("--all: no longer exists; run `python -m benchmarks.crosscheck` in a checkout of tatamu")
    if not simulator:
        raise InputError("--simulator: must be native, blender or mujoco, given none")
    require(simulator)
    learned = Result.load(folder)
    given = None if material is None else load_material(material)
    prepare(simulator)
    with progress(f"{learned.name} in {simulator}"):
        opinion = run(learned, simulator, material=given, halved=halve)
    page = save(opinion, out or folder / f"check-{simulator}")
    here, there = learned.simulator, f"{simulator} with half the spacing" if halve else simulator
    print(f"{here}: {_words(learned.score)}")
    if opinion.score is None:
        print(f"{there}: {opinion.error}")
    else:
        print(f"{there}: {_words(opinion.score)}; {1e3 * opinion.apart.mean():.1f} mm from the fold in {here}")
    print(f"the fold {'succeeds' if opinion.holds else 'fails'} in {there}: {page}")
    return 0 if opinion.holds else 1


def _words(score: Score) -> str:
    distance = 1e3 * score.mean_vertex_distance
    return f"{distance:.1f} mm from the target, IoU {score.mask_iou:.3f}, C = {score.objective:.4f}"
