"""Which small garments HIRONX folds, for docs/robots.md: each learned within its reach, each step planned.

    python benchmarks/robots.py --out runs/robots [--robot hironx] [--trials 6] [--write-docs]

Prints a table and writes `table.json`; a study that is there already is not run again.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tables import insert, markdown

from tatamu.errors import TatamuError
from tatamu.files import read_json, write_json
from tatamu.folding.task import Job, Reach, make_job
from tatamu.learning import learn_job
from tatamu.robots import Plan, ReachConstraint, load, plan_fold, save

SPACING = 0.02


@dataclass(frozen=True)
class Case:
    """A garment of one size, folded in one way."""

    garment: str
    size: tuple[float, float]
    """Width and length [m]."""
    fold: str

    @property
    def name(self) -> str:
        """Of its folders."""
        return f"{self.garment}-{self.fold}-{self.size[0]:.2f}x{self.size[1]:.2f}"


CASES = (
    Case("tshirt", (0.40, 0.34), "half"),
    Case("tshirt", (0.40, 0.34), "shop"),
    Case("tshirt", (0.46, 0.40), "half"),
    Case("tshirt", (0.52, 0.46), "half"),
    Case("trousers", (0.28, 0.45), "leg"),
    Case("trousers", (0.28, 0.45), "thirds"),
    Case("trousers", (0.24, 0.36), "half"),
    Case("trousers", (0.28, 0.45), "half"),
    Case("towel", (0.30, 0.36), "half"),
    Case("towel", (0.34, 0.50), "half"),
)


def rows_of(case: Case, robot: str, out: Path, trials: int) -> list[dict[str, Any]]:
    """One row for each step, or one that says why nothing was learned."""
    loaded = load(robot)
    constraint = ReachConstraint(loaded)
    reach = Reach(loaded.name, constraint, constraint.refusal)
    head = {"garment": case.garment, "size [m]": f"{case.size[0]:.2f} x {case.size[1]:.2f}", "fold": case.fold}
    try:
        job = make_job(case.garment, size=case.size, fold=case.fold, spacing=SPACING, reach=reach)
        learn_job(job, out / case.name, trials=trials, baselines=False)
    except TatamuError as error:
        return [{**head, **row(answer=f"not learned: {str(error).replace(f'{out}/', '')}")}]
    return [{**head, **planned(folder, robot, out / "plans" / case.name)} for folder in step_folders(job, out, case)]


def step_folders(job: Job, out: Path, case: Case) -> list[Path]:
    """Folders of the learned steps."""
    count = len(job.plan.steps)
    return [out / case.name] if count == 1 else [out / case.name / f"step-{n + 1}" for n in range(count)]


def planned(folder: Path, robot: str, plans: Path) -> dict[str, Any]:
    """Plan one learned fold."""
    result = read_json(folder / "result.json")
    best, within = result["trials"][result["best"]], [t for t in result["trials"] if t["state"] == "complete"]
    learned = {
        "step": f"{result['task'].get('step', [1])[0]}",
        "span": f"{max(map(abs, result['task']['translation'][:2])):.2f}",
        "within": f"{len(within)} of {len(result['trials'])}",
        "distance": f"{1e3 * best['mean_vertex_distance']:.1f}",
    }
    try:
        plan = plan_fold(folder, load(robot))
    except TatamuError as error:
        return row(**learned, answer=f"refused: {str(error).split(': ', 1)[1]}")
    save(plan, plans / f"step-{learned['step']}")
    return row(**learned, answer=described(plan))


def described(plan: Plan) -> str:
    """A plan in a few words."""
    return f"{plan.motion.times[-1]:.1f} s, fold {plan.checks['time_scaling'].value:.2f} times slower"


def row(answer: str, step: str = "-", span: str = "-", within: str = "-", distance: str = "-") -> dict[str, Any]:
    """The columns after garment, size and fold."""
    return {
        "step": step,
        "corner moves [m]": span,
        "trials within reach": within,
        "mean distance [mm]": distance,
        "plan": answer,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--robot", default="hironx")
    parser.add_argument("--trials", type=int, default=6)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    rows = []
    for case in CASES:
        rows += rows_of(case, options.robot, options.out, options.trials)
        print(rows[-1], flush=True)
    write_json(options.out / "table.json", rows)
    print(markdown(rows))
    if options.write_docs:
        insert("garments within reach", markdown(rows), Path("docs/robots.md"))


if __name__ == "__main__":
    main()
