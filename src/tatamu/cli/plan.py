"""The command `tatamu plan`, which plans a robot's motion for a learned fold."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from tatamu.base.errors import InputError
from tatamu.cli.app import app


@app.command()
def plan(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a learned fold.")],
    out: Annotated[Path, typer.Option(metavar="PLAN", help="Folder of the plan.")],
    robot: Annotated[
        str | None,
        typer.Option(
            help="hironx, nextage, fr3-pair, panda-pair, ur5e-pair, xarm7-pair, so101-pair, aloha2, openarm, or a "
            ".toml that describes a robot; default: the one for which the fold was learned, otherwise hironx."
        ),
    ] = None,
    table_height: Annotated[
        float | None,
        typer.Option(help="Height of the table top in the robot's base frame [m]; default: found by search."),
    ] = None,
    place: Annotated[
        str, typer.Option(metavar="auto|X,Y,YAW", help="Place of the fold's frame in the base [m, m, rad].")
    ] = "auto",
    speed_scale: Annotated[
        float,
        typer.Option(min=0.05, max=1.0, help="Factor of the motion's speed; waits change with it."),
    ] = 1.0,
    hover: Annotated[
        float,
        typer.Option(
            metavar="METRES",
            help="Make the motion this far above the table with open jaws, to watch it before it folds [m].",
        ),
    ] = 0.0,
    lerobot: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Also write the motion as a LeRobotDataset of one episode, for lerobot-replay."
        ),
    ] = None,
    wrist_offset: Annotated[
        float | None,
        typer.Option(help="HIRONX, NEXTAGE: distance from J4 to J5 along x [m]; default -0.047; -0.040 on old HIRONX."),
    ] = None,
    fingertip: Annotated[
        float | None,
        typer.Option(
            help="HIRONX, NEXTAGE: distance from the last joint to the fingertip [m]; default 0.093, NEXTAGE 0.19."
        ),
    ] = None,
) -> None:
    """Plan the motion of a dual-arm robot for a learned fold, check the plan, and write it for ROS.

    Examples:
    `tatamu plan runs/hand-towel --robot hironx --out runs/hand-towel-plan`

    `tatamu plan runs/shop/step-1 --robot nextage --out runs/shop-plan-1`

    `tatamu plan runs/hand-towel --out runs/look --hover 0.10 --speed-scale 0.25`

    `tatamu plan runs/hand-towel --robot panda-pair --out runs/plan --lerobot runs/episode`
    """
    from tatamu.robots import check_out, load, plan_fold, save
    from tatamu.robots.checks import in_words
    from tatamu.robots.episode import add_plan, episode_writer
    from tatamu.robots.motion import Pace
    from tatamu.robots.plan import NoPlacement

    check_out(out)
    learned_for = _robot_of(folder)
    chosen = robot or learned_for or "hironx"
    loaded = load(chosen, wrist_offset, fingertip)
    for note in loaded.notes:
        print(f"note: {note}")
    with ExitStack() as stack:
        dataset = None if lerobot is None else stack.enter_context(episode_writer(loaded, lerobot))
        try:
            result = plan_fold(
                folder, loaded, _place(place), _height(table_height), Pace(speed_scale=speed_scale), _hover(hover)
            )
        except NoPlacement as error:
            if learned_for is not None and load(learned_for).name == loaded.name:
                raise
            remedy = f"`tatamu learn .. --robot {chosen}` searches only folds within its reach"
            raise NoPlacement(f"{error}; {remedy}") from None
        if dataset is not None:
            add_plan(dataset, result)
        save(result, out)
    print(f"{out}: {result.motion.times[-1]:.1f} s; the fold lies at {result.task.hovering(0.0).placement}")
    if hover:
        print(f"  the hands move {1e3 * hover:.0f} mm above it with open jaws: nothing is folded")
    for name, check in result.checks.items():
        value, unit, limit = in_words(check.value, check.limit, check.unit, check.ok)
        print(f"  {name.replace('_', ' '):28} {value:>10} {unit:8} ({limit})")


def _robot_of(folder: Path) -> str | None:
    """Return the name or file of the robot for which a fold was learned; None if it was learned without a robot."""
    from tatamu.study.folder import ResultFolder
    from tatamu.study.inputs import kept_input

    results = ResultFolder(folder)
    if not results.result_file.exists() or results.holds_plan:
        return None
    kept = kept_input(folder, "robot")
    return str(kept) if kept else results.record.task.robot


def _height(value: float | None) -> float | None:
    if value is not None and not abs(value) < 10:
        raise InputError(f"--table-height: must be within 10 m, given {value:g}")
    return value


def _hover(value: float) -> float:
    if value and not 0.02 <= value <= 0.5:
        raise InputError(f"--hover: must be 0 or from 0.02 to 0.5 m, given {value:g}")
    return value


def _place(text: str) -> tuple[float, float, float] | None:
    if text == "auto":
        return None
    try:
        x, y, yaw = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--place: must be auto or x,y,yaw in metres and radians, given {text!r}") from None
    if not (abs(x) < 10 and abs(y) < 10 and abs(yaw) < 6.3):
        raise InputError(f"--place: x and y must be within 10 m and yaw within 6.3 rad, given {text!r}")
    return x, y, yaw
