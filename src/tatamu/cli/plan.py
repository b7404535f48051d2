"""The command `tatamu plan`, which plans a robot's motion for a learned fold."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tatamu.base.errors import InputError

if TYPE_CHECKING:
    from tatamu.robots import RobotPlan


def plan(
    folder: Path = typer.Argument(..., metavar="DIR", help="The folder of a learned fold."),
    out: Path = typer.Option(..., metavar="PLAN", help="Folder of the plan."),
    robot: str | None = typer.Option(
        None,
        metavar="NAME|FILE.toml,..",
        help="hironx, nextage, fr3-pair, panda-pair, ur5e-pair, xarm7-pair, so101-pair, aloha2, openarm, or a "
        ".toml file that describes a robot. Default: the robot for which the fold was learned, otherwise "
        "hironx. Several robots, separated by commas, get a folder PLAN/ROBOT each.",
    ),
    table_height: float | None = typer.Option(
        None, help="Height of the table top in the robot's base frame [m]; default: found by search."
    ),
    place: str = typer.Option(
        "auto",
        metavar="auto|X,Y,YAW",
        help="Pose of the fold's frame in the robot's base frame [m, m, rad]; auto: found by search.",
    ),
    speed_scale: float = typer.Option(
        1.0,
        min=0.05,
        max=1.0,
        help="Fraction of the planned speed; below 1, pauses also become longer, for example while the jaws close.",
    ),
    hover: float = typer.Option(
        0.0,
        metavar="METRES",
        help="Raise the whole motion by this height [m] and keep the jaws open, so that nothing is folded.",
    ),
    lerobot: Path | None = typer.Option(
        None, metavar="DIR", help="Also write the motion as a LeRobotDataset of one episode, for lerobot-replay."
    ),
    wrist_offset: float | None = typer.Option(
        None,
        help="HIRONX, NEXTAGE: position of J5 from J4 along x [m]; default: -0.047; for an old HIRONX, give -0.040.",
    ),
    fingertip: float | None = typer.Option(
        None,
        help="HIRONX, NEXTAGE: distance from the last joint to the fingertip [m]; default: 0.093, or 0.19 for NEXTAGE.",
    ),
) -> None:
    """Plan the motion of a dual-arm robot for a learned fold, check the plan, and write it for ROS.

    Examples:
    `tatamu plan runs/hand-towel --robot hironx --out runs/hand-towel-plan`

    `tatamu plan runs/shop/step-1 --robot nextage --out runs/shop-plan-1`

    `tatamu plan runs/hand-towel --out runs/look --hover 0.10 --speed-scale 0.25`

    `tatamu plan runs/hand-towel --robot panda-pair --out runs/plan --lerobot runs/episode`

    `tatamu plan runs/hand-towel --robot hironx,aloha2,openarm --out runs/plans`
    """
    from tatamu.robots import check_out, load, plan_fold, save
    from tatamu.robots.episode import add_plan, episode_writer
    from tatamu.robots.motion import Pace
    from tatamu.robots.plan import NoPlacement
    from tatamu.show.progress import progress

    learned_for = _robot_of(folder)
    asked = robot or learned_for or "hironx"  # a file whose name contains commas is one robot
    chosen = [asked] if Path(asked).is_file() else list(dict.fromkeys(name.strip() for name in asked.split(",")))
    if lerobot is not None and len(chosen) > 1:
        raise InputError("--lerobot: must be given with a single robot, given several")
    robots = {name: load(name, wrist_offset, fingertip) for name in chosen}
    outs = {name: out if len(chosen) == 1 else out / loaded.name for name, loaded in robots.items()}
    if len(set(outs.values())) < len(outs):
        raise InputError("--robot: all robots must have different names, given two with the same name")
    for path in outs.values():
        check_out(path)
    own = load(learned_for).name if learned_for is not None else None
    pose = _place(place)
    if table_height is not None and not abs(table_height) < 10:
        raise InputError(f"--table-height: must be between -10 and 10 m, given {table_height:g}")
    pace = Pace(speed_scale=speed_scale)
    if hover and not 0.02 <= hover <= 0.5:
        raise InputError(f"--hover: must be 0 or from 0.02 to 0.5 m, given {hover:g}")
    refusals = []
    for name, loaded in robots.items():
        for note in loaded.notes:
            print(f"note: {note}")
        try:
            with ExitStack() as stack:
                dataset = None if lerobot is None else stack.enter_context(episode_writer(loaded, lerobot))
                with progress(f"placing the fold for {loaded.name}", unit="placements") as report:
                    result = plan_fold(folder, loaded, pose, table_height, pace, hover, report)
                if dataset is not None:
                    add_plan(dataset, result)
        except InputError as error:
            if len(chosen) > 1:
                label = f"{loaded.name}: "
                print(label + str(error).removeprefix(f"{folder}: ").removeprefix(label))
            reason = f"{error}; `tatamu learn .. --robot {name}` tries only folds that this robot can reach"
            for_others = isinstance(error, NoPlacement) and own != loaded.name
            refusals.append(NoPlacement(reason) if for_others else error)
            continue
        save(result, outs[name])
        _print(result, outs[name], hover, with_checks=len(chosen) == 1)
    if len(refusals) == len(chosen):
        raise refusals[0]


def _print(result: RobotPlan, out: Path, hover: float, *, with_checks: bool) -> None:
    from tatamu.robots.checks import in_words

    place = result.task.hovering(0.0).placement
    print(f"{out}: the motion takes {result.motion.times[-1]:.1f} s; the fold is placed at {place}")
    if hover:
        print(f"  the whole motion is raised by {1e3 * hover:.0f} mm with open jaws, so nothing is folded")
    for name, check in result.checks.items() if with_checks else ():
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


def _place(text: str) -> tuple[float, float, float] | None:
    if text == "auto":
        return None
    try:
        x, y, yaw = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--place: must be auto or x,y,yaw in metres and radians, given {text!r}") from None
    if not (abs(x) < 10 and abs(y) < 10 and abs(yaw) < 6.3):
        raise InputError(
            f"--place: x and y must be between -10 and 10 m, and yaw between -6.3 and 6.3 rad, given {text!r}"
        )
    return x, y, yaw
