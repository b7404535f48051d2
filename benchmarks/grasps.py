"""How each robot takes a small towel by the hem, folds it and comes out: one row each, for docs/notes/robots.md.

    python -m benchmarks.grasps --out runs/grasps [--only panda] [--trials 4] [--no-cloth] [--write-docs]

Each towel is learned within its robot's reach on a coarse mesh, planned, and rehearsed by the embedded simulator. What
is there already is not run again. A row takes a few minutes. With `--no-cloth` nothing is learned or simulated but the
robot: the fold is the one in the middle of the search space, held at the corners.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from benchmarks.tables import markdown, publish

from tatamu.api import Result, learn
from tatamu.errors import TatamuError
from tatamu.files import read_json, write_json
from tatamu.folding.task import Reach, make_task
from tatamu.options import LearnOptions
from tatamu.robots import ReachConstraint, load, plan_fold, save
from tatamu.robots.planned import Planned
from tatamu.robots.refold import refold
from tatamu.robots.rehearsal import rehearse
from tatamu.robots.report import save as save_rehearsal
from tatamu.study.folder import MANIPULATION

SPACING = 0.03
"""Of the meshes [m]."""
TOWELS = {
    "hironx": (0.30, 0.36),
    "nextage": (0.30, 0.36),
    "fr3-pair": (0.50, 0.70),
    "panda-pair": (0.50, 0.70),
    "ur5e-pair": (0.50, 0.70),
    "xarm7-pair": (0.50, 0.70),
    "so101-pair": (0.24, 0.18),
    "aloha2": (0.34, 0.40),
    "openarm": (0.34, 0.40),
}
"""Width and length of each robot's towel [m]."""
MATERIALS = {"so101-pair": "cotton"}
"""Of towels that are too small to be creased in terry."""


def row(name: str, out: Path, trials: int) -> dict[str, Any]:
    """Learn, plan and rehearse one robot's towel."""
    size = TOWELS[name]
    head = {"robot": name, "towel [m]": f"{size[0]:.2f} x {size[1]:.2f}"}
    try:
        return {**head, **_row(name, size, out / name, trials)}
    except TatamuError as error:
        return {**head, "result": f"refused: {str(error).replace(f'{out}/', '')}"}


def _row(name: str, size: tuple[float, float], out: Path, trials: int) -> dict[str, Any]:
    robot = load(name)
    constraint = ReachConstraint(robot)
    reach = Reach(robot.name, constraint, constraint.refusal, constraint.forget)
    task = make_task("towel", size=size, material=MATERIALS.get(name), spacing=SPACING, reach=reach)
    if trials:
        result = learn(task, LearnOptions(trials=trials, disturbances="none", baselines=False), out=out / "fold")
        assert isinstance(result, Result), "a towel has one step"
    else:
        task.manipulation({**task.space.middle(), "g1": 0, "g2": 0}).save(out / "fold" / MANIPULATION)
    if not (out / "plan").is_dir():
        save(plan_fold(out / "fold", robot), out / "plan")
    planned = Planned.load(out / "plan")
    note = out / "rehearsal" / "rehearsal.json"
    if not note.is_file():
        motion = rehearse(planned)
        save_rehearsal(motion, out / "rehearsal", refold(motion, "native") if trials else None)
    told, plan = read_json(note), planned.plan
    checks, jaws = plan.checks, list(plan.jaws.values())
    fold = told["fold"]
    cloth = checks.get("distance_to_the_cloth")
    return {
        "tilt, yaw [deg]": "; ".join(f"{math.degrees(jaw.tilt):.0f}, {math.degrees(abs(jaw.yaw)):.0f}" for jaw in jaws),
        "fingertips over the table [mm]": "; ".join(f"{1e3 * jaw.height:.1f}" for jaw in jaws),
        "cloth in the closed jaw [mm]": f"{1e3 * checks['cloth_in_the_closed_jaw'].value:.1f}",
        "arms to table, to cloth [mm]": ", ".join(
            "-" if check is None else f"{1e3 * check.value:.0f}" for check in (checks["distance_to_the_table"], cloth)
        ),
        "plan": f"{plan.duration:.1f} s, {checks['time_scaling'].value:.2f} times slower",
        "tools off the plan [mm]": f"{1e3 * told['tool_error']:.1f}",
        "mean distance, IoU: learned": _score(fold, "learned"),
        "floating hands": _score(fold, "floating"),
        "the robot's hands": _score(fold, "robot"),
        "result": "all checks pass" if not told["contacts"] else f"{told['contacts'][0]['links']} touch",
    }


def _score(fold: dict[str, Any] | None, name: str) -> str:
    if fold is None:
        return "-"
    score = fold["scores"][name]
    return f"{1e3 * score['mean_vertex_distance']:.1f} mm, {score['mask_iou']:.3f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--trials", type=int, default=4)
    parser.add_argument("--no-cloth", action="store_true", help="the robot alone")
    parser.add_argument("--only", default="", help="a word in the robots' names")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for name in TOWELS:
        if options.only in name:
            rows.append(row(name, options.out, 0 if options.no_cloth else options.trials))
            print(rows[-1], flush=True)
    columns = list(dict.fromkeys(key for each in rows for key in each))
    text = markdown([{key: each.get(key, "-") for key in columns} for each in rows])
    write_json(options.out / "table.json", rows)
    print(text)
    if options.write_docs:
        publish("grasps", text)


if __name__ == "__main__":
    main()
