"""Which small garments HIRONX folds, for docs/notes/robots.md: each learned within its reach, each step planned.

    python benchmarks/robots.py --out runs/robots [--robot hironx] [--trials 6] [--write-docs]
        [--rehearse native,mujoco] [--halvings 0] [--only towel]

Prints a table and writes `table.json`; what is there already, a study, a plan, a rehearsal, is not run again.
MuJoCo's rehearsals take minutes to an hour: the longer, the finer the mesh.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.tables import markdown, publish
from tatamu.api import learn
from tatamu.base.errors import TatamuError
from tatamu.base.files import read_json, write_json
from tatamu.folding.task import Reach, make_task
from tatamu.robots import ReachConstraint, load, plan_fold, save
from tatamu.robots.planned import Planned
from tatamu.robots.refold import refold
from tatamu.robots.rehearsal import rehearse
from tatamu.robots.report import save as save_rehearsal
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

SPACING = 0.02
SIMULATORS = ("native", "mujoco")
"""Simulators that may rehearse."""


@dataclass(frozen=True)
class Case:
    """A garment, its size and its fold."""

    garment: str
    size: tuple[float, float]
    """Width and length [m]."""
    fold: str

    @property
    def name(self) -> str:
        """Name of its folders."""
        return f"{self.garment}-{self.fold}-{self.size[0]:.2f}x{self.size[1]:.2f}"


CASES = (
    Case("tshirt", (0.40, 0.34), "half"),
    Case("tshirt", (0.40, 0.34), "shop"),
    Case("tshirt", (0.46, 0.40), "half"),
    Case("tshirt", (0.52, 0.46), "half"),
    Case("trousers", (0.28, 0.45), "leg"),
    Case("trousers", (0.34, 0.60), "leg"),
    Case("trousers", (0.28, 0.45), "thirds"),
    Case("trousers", (0.24, 0.36), "half"),
    Case("trousers", (0.28, 0.45), "half"),
    Case("towel", (0.30, 0.36), "half"),
    Case("towel", (0.34, 0.40), "half"),
    Case("towel", (0.50, 0.34), "half"),
    Case("towel", (0.34, 0.50), "half"),
)


@dataclass(frozen=True)
class Setting:
    """The options of every case."""

    robot: str
    out: Path
    trials: int
    simulators: tuple[str, ...]
    """Simulators that rehearse."""
    halvings: int | None


def rows_of(case: Case, setting: Setting) -> list[dict[str, Any]]:
    """One row for each step, or one that says why nothing was learned."""
    loaded, out = load(setting.robot), setting.out
    constraint = ReachConstraint(loaded)
    reach = Reach(loaded.name, constraint, constraint.refusal)
    head = {"garment": case.garment, "size [m]": f"{case.size[0]:.2f} x {case.size[1]:.2f}", "fold": case.fold}
    try:
        task = make_task(case.garment, size=case.size, fold=case.fold, spacing=SPACING, reach=reach)
        options = LearnOptions(trials=setting.trials, disturbances="none", baselines=False)
        result = learn(task, options, out=out / case.name)
    except TatamuError as error:
        return [{**head, **row(answer=f"not learned: {str(error).replace(f'{out}/', '')}")}]
    steps = [result] if isinstance(result, Result) else result.steps
    return [{**head, **planned(step, setting, out / "plans" / case.name)} for step in steps]


def planned(result: Result, setting: Setting, plans: Path) -> dict[str, Any]:
    """Plan and rehearse one learned fold."""
    task = result.record.task
    assert result.folder is not None and task.translation is not None, "tatamu wrote it"
    within = [trial for trial in result.trials if trial.state == "complete"]
    learned = {
        "step": str(task.step[0] if task.step else 1),
        "span": f"{max(map(abs, task.translation[:2])):.2f}",
        "within": f"{len(within)} of {len(result.trials)}",
        "distance": f"{1e3 * result.score.mean_vertex_distance:.1f}",
    }
    plan = plans / f"step-{learned['step']}"
    try:
        answer = described(result.folder, setting.robot, plan)
    except TatamuError as error:
        return row(**learned, answer=f"refused: {str(error).split(': ', 1)[1]}")
    return row(**learned, answer=answer, rehearsed={name: rehearsed(plan, setting, name) for name in SIMULATORS})


def described(folder: Path, robot: str, plan: Path) -> str:
    """Return the plan of a fold in a few words."""
    note = plan.parent / f"{plan.name}.json"
    if not note.is_file():
        begun = time.process_time()
        made = plan_fold(folder, load(robot))
        seconds = time.process_time() - begun
        save(made, plan)
        slower = made.checks["time_scaling"].value
        write_json(note, {"cpu": seconds, "duration": float(made.motion.times[-1]), "slower": slower})
    told = read_json(note)
    return f"{told['duration']:.1f} s, fold {told['slower']:.2f} times slower; planned in {told['cpu']:.1f} s (CPU)"


def rehearsed(plan: Path, setting: Setting, simulator: str) -> str:
    """How the fold that the robot's hands make compares with floating hands, in a few words."""
    note = plan.parent / f"{plan.name}-{simulator}.json"
    if simulator in setting.simulators and not note.is_file():
        motion = rehearse(Planned.load(plan))
        fold = refold(motion, simulator, setting.halvings)
        write_json(note, save_rehearsal(motion, plan / f"rehearsal-{simulator}", fold))
    if not note.is_file():
        return "-"
    fold_told = read_json(note)["fold"]
    robot, floating = (fold_told["scores"][name] for name in ("robot", "floating"))
    return (
        f"{1e3 * fold_told['distance_to_floating_hands']:.1f} "
        f"({robot['mask_iou']:.3f}, {floating['mask_iou']:.3f}; {fold_told['simulated_vertices']})"
    )


def row(
    answer: str, step: str = "-", span: str = "-", within: str = "-", distance: str = "-", **more: Any
) -> dict[str, Any]:
    """Return the columns after garment, size and fold."""
    rehearsals = more.get("rehearsed", {})
    return {
        "step": step,
        "corner moves [m]": span,
        "trials within reach": within,
        "mean distance [mm]": distance,
        "plan": answer,
        **{f"rehearsed in {name}": rehearsals.get(name, "-") for name in SIMULATORS},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--robot", default="hironx")
    parser.add_argument("--trials", type=int, default=6)
    parser.add_argument("--rehearse", default="native", help="simulators, with commas between")
    parser.add_argument("--halvings", type=int, help="of the mesh; default: as the simulator needs")
    parser.add_argument("--only", help="a word in the cases' names")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    simulators = tuple(name for name in options.rehearse.split(",") if name)
    setting = Setting(options.robot, options.out, options.trials, simulators, options.halvings)
    rows: list[dict[str, Any]] = []
    for case in [case for case in CASES if not options.only or options.only in case.name]:
        rows += rows_of(case, setting)
        print(rows[-1], flush=True)
    write_json(options.out / "table.json", rows)
    print(markdown(rows))
    if options.write_docs:
        publish("garments within reach", markdown(rows))


if __name__ == "__main__":
    main()
