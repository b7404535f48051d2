"""Whether pressed creases help the last step of a plan: the table "pressed" of docs/notes/folds.md.

    tatamu learn tshirt --fold shop --disturbances none --out runs/shop
    python -m benchmarks.pressed runs/shop --out runs/pressed [--weights 5 20] [--write-docs]

The steps of a learned plan but the last are simulated again with their learned manipulations. Their creases are pressed
by a plate, or not. The last step is then simulated from the state of the cloth, along the curves with which its search
starts, and along the learned curve. Simulations are kept in the folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.tables import markdown, publish
from tatamu.base.files import read_json, write_json
from tatamu.evaluation import Nominal
from tatamu.folding.parameters import later_curves
from tatamu.folding.press import Press
from tatamu.folding.task import Task
from tatamu.study.plan import PlanResult
from tatamu.study.result import Result


def pressed(task: Task, weight: float) -> Task:
    """Return the same plan, with a plate of a weight [N] on the crease of every step but the last; 0 for no plate."""
    press = Press(weight=weight) if weight else None
    *first, last = task.plan.steps
    steps = (*(step.model_copy(update={"press": press}) for step in first), last)
    return replace(task, plan=task.plan.model_copy(update={"steps": steps}))


def last_step(task: Task, steps: Sequence[Result]) -> tuple[float, list[list[float]]]:
    """Return the height of the cloth before the last step [m], and for each curve the distance [m] and the overlap."""
    state = None
    for number, step in enumerate(steps[:-1]):
        found = Nominal(task.at(number, state))(step.best.parameters)
        assert found.rollout is not None, found.error
        state = found.rollout.positions[-1]
    assert state is not None, "a plan has several steps"
    last = task.at(len(steps) - 1, state)
    curves = [*later_curves(last.fold), steps[-1].best.parameters]
    scores = [Nominal(last)(curve).score for curve in curves]
    values = [[score.mean_vertex_distance, score.mask_iou] for score in scores if score is not None]
    return float(state[:, 2].max()), values


def row(name: str, height: float, values: Sequence[Sequence[float]]) -> dict[str, str]:
    """Return a row of the table."""
    *given, learned = values
    return {
        "creases": name,
        "height before the last step [mm]": f"{1e3 * height:.0f}",
        "given curves [mm]": ", ".join(f"{1e3 * distance:.1f}" for distance, _ in given),
        "their overlaps": ", ".join(f"{overlap:.2f}" for _, overlap in given),
        "learned curve [mm]": f"{1e3 * learned[0]:.1f}",
        "its overlap": f"{learned[1]:.2f}",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="folder of a learned plan")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--weights", type=float, nargs="+", default=[5.0], help="of the plate [N]")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    plan = PlanResult.load(options.run)
    table = []
    for weight in [0.0, *options.weights]:
        file = options.out / f"{weight:g}.json"
        if not file.exists():
            options.out.mkdir(parents=True, exist_ok=True)
            write_json(file, last_step(pressed(plan.steps[0].task, weight), plan.steps))
        name = f"pressed with {weight:g} N" if weight else "not pressed"
        table.append(row(name, *read_json(file)))
    print(markdown(table))
    if options.write_docs:
        publish("pressed", markdown(table))


if __name__ == "__main__":
    main()
