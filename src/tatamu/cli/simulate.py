"""The commands `tatamu simulate`, which simulates a scene file, and `install`, which installs a simulator."""

from __future__ import annotations

from pathlib import Path

import typer

from tatamu.base.errors import InputError


def simulate(
    scene: Path = typer.Argument(..., metavar="SCENE.json", help="The scene file."),
    out: Path = typer.Option(..., metavar="ROLLOUT.npz", help="Rollout file to write."),
    simulator: str = typer.Option("native", help="Simulator: native, blender or mujoco."),
) -> None:
    """Simulate a scene file, and write the motion of the cloth to a rollout file.

    Example: `tatamu simulate runs/towel/scene.json --out again.npz`
    """
    from tatamu.base.files import check_targets
    from tatamu.cli.progress import prepare
    from tatamu.simulation.scene import Scene
    from tatamu.simulation.simulators import require
    from tatamu.simulation.simulators import simulate as run

    check_targets([out], [scene])
    require(simulator)
    loaded = Scene.load(scene)
    prepare(simulator)
    rollout = run(loaded, simulator=simulator)
    rollout.save(out)
    info = rollout.info
    print(f"{out}: {len(rollout.times)} frames, simulated by {info['simulator']} in {info['wall_seconds']:.2f} s")
    for warning in info["warnings"]:
        print(f"warning: {warning}")


def install(
    what: str = typer.Argument(..., metavar="WHAT", help="Simulator to install: blender."),
) -> None:
    """Install Blender (about 1 GB) in a folder where tatamu finds it, for the option `--simulator blender`.

    Example: `tatamu install blender`
    """
    if what != "blender":
        raise InputError(f"install: must be followed by blender, given {what!r}")
    from tatamu.simulation.blender.discovery import install as make

    print(f"blender: {make()}")
