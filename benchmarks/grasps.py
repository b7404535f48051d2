"""How each robot takes a small towel and a T-shirt by the hem, folds it and comes out, for docs/notes/robots.md.

    python -m benchmarks.grasps --out runs/grasps [--only panda] [--garment towel] [--no-cloth] [--write-docs]

Each garment is learned within its robot's reach on a coarse mesh, planned, and rehearsed by the embedded simulator.
What is there already is not run again, and rows that are not run keep their place in the table. A row takes a few
minutes.
With `--no-cloth` nothing is learned or simulated but the robot: the fold is the one in the middle of the search space,
held at the corners.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.tables import markdown, merged, publish, published
from tatamu.api import Result, learn
from tatamu.base.errors import TatamuError
from tatamu.base.files import read_json, write_json
from tatamu.evaluation.disturbances import default_disturbances
from tatamu.folding.task import Task, make_task
from tatamu.robots import load, plan_fold, save
from tatamu.robots.constraint import find_reach
from tatamu.robots.planned import Planned
from tatamu.robots.refold import refold
from tatamu.robots.rehearsal import rehearse
from tatamu.robots.report import save as save_rehearsal
from tatamu.study.folder import MANIPULATION
from tatamu.study.options import LearnOptions

SPACING = 0.03
"""Spacing of the meshes [m]."""
LIMP = "polyester"
"""Material of towels that are too small to be creased in terry."""


class Trial(NamedTuple):
    """A garment for a robot."""

    robot: str
    garment: str
    size: tuple[float, float]
    """Width and length [m]."""
    hands: int = 2
    material: str | None = None
    disturbed: bool = False
    """Whether the fold is learned with the default disturbances. Hands then move higher, so arms keep away from the
    cloth."""

    @property
    def text(self) -> str:
        """Return the garment as text."""
        hands = ", one hand" if self.hands == 1 else ""
        return f"{self.garment} {self.size[0]:.2f} x {self.size[1]:.2f}{hands}{', disturbed' if self.disturbed else ''}"

    def task(self) -> Task:
        """Return the task within the robot's reach."""
        spacing = min(SPACING, self.size[1] / 8)
        return make_task(
            self.garment,
            size=self.size,
            spacing=spacing,
            hands=self.hands,
            material=self.material,
            reach=find_reach(self.robot),
        )


TRIALS = (
    *(Trial(robot, "towel", (0.30, 0.36)) for robot in ("hironx", "nextage")),
    *(Trial(f"{arm}-pair", "towel", (0.50, 0.70)) for arm in ("fr3", "panda", "ur5e", "xarm7")),
    Trial("so101-pair", "towel", (0.24, 0.24), hands=1, material=LIMP),
    Trial("aloha2", "towel", (0.34, 0.40), disturbed=True),
    Trial("openarm", "towel", (0.30, 0.24), material=LIMP, disturbed=True),
    *(Trial(robot, "tshirt", (0.40, 0.34)) for robot in ("hironx", "nextage")),
    *(Trial(robot, "tshirt", (0.40, 0.34), disturbed=True) for robot in ("aloha2", "openarm")),
    *(Trial(f"{arm}-pair", "tshirt", (0.54, 0.46)) for arm in ("fr3", "panda", "ur5e", "xarm7")),
)


def row(trial: Trial, out: Path, trials: int) -> dict[str, str]:
    """Learn, plan and rehearse a garment."""
    head = {"robot": trial.robot, "garment [m]": trial.text}
    try:
        return {**head, **_row(trial, out / f"{trial.robot}-{trial.garment}", trials)}
    except TatamuError as error:
        return {**head, "result": f"refused: {str(error).replace(f'{out}/', '')}"}


def _row(trial: Trial, out: Path, trials: int) -> dict[str, str]:
    task = trial.task()
    if trials:
        disturbances = default_disturbances() if trial.disturbed else "none"
        options = LearnOptions(trials=trials, disturbances=disturbances, baselines=False)
        result = learn(task, options, out=out / "fold")
        assert isinstance(result, Result), "these folds have one step"
    else:
        task.manipulation({**task.space.middle(), "g1": 0, "g2": 0}).save(out / "fold" / MANIPULATION)
    if not (out / "plan").is_dir():
        save(plan_fold(out / "fold", load(trial.robot)), out / "plan")
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


def before() -> list[dict[str, str]]:
    """HIRONX's figures with fingers side by side along the hem, from the page's first table, which is kept."""
    rows = []
    for trial in TRIALS:
        size = f"{trial.size[0]:.2f} x {trial.size[1]:.2f}"
        for old in published("garments within reach") if trial.robot == "hironx" else []:
            if (old["garment"], old["size [m]"], old["fold"]) == (trial.garment, size, "half"):
                apart, robots, floating = old["rehearsed in native"].replace("(", ",").replace(";", ",").split(",")[:3]
                rows.append(
                    {
                        "robot": "hironx, as it was",
                        "garment [m]": trial.text,
                        "plan": old["plan"].split(";")[0].replace("fold ", ""),
                        "mean distance, IoU: learned": f"{old['mean distance [mm]']} mm",
                        "floating hands": f"IoU {floating.strip()}",
                        "the robot's hands": f"{apart.strip()} mm from floating hands, IoU {robots.strip()}",
                        "result": "no finger under the cloth",
                    }
                )
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--trials", type=int, default=4)
    parser.add_argument("--no-cloth", action="store_true", help="the robot alone")
    parser.add_argument("--only", default="", help="a word in the robots' names")
    parser.add_argument("--garment", choices=("towel", "tshirt"), help="only this garment")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    rows: list[dict[str, str]] = []
    for trial in TRIALS:
        if options.only in trial.robot and options.garment in (None, trial.garment):
            rows.append(row(trial, options.out, 0 if options.no_cloth else options.trials))
            print(rows[-1], flush=True)
    rows = merged(published("grasps"), [*rows, *before()], "robot", "garment [m]")
    columns = list(dict.fromkeys(key for each in rows for key in each))
    columns.append(columns.pop(columns.index("result")))
    text = markdown([{key: each.get(key, "-") for key in columns} for each in rows])
    write_json(options.out / "table.json", rows)
    print(text)
    if options.write_docs:
        publish("grasps", text)


if __name__ == "__main__":
    main()
