"""The method of Li et al. (2015), with which the paper compares its own: Levenberg-Marquardt over the hands' curve.

    python -m studies.paper.li towel --trials 50 --out runs/li/towel.json

The hands grasp the corners, and the inner control points P1 and P2 of the Bezier curve are varied. The squares of the
residuals sum to the objective C of Eq. (10): sqrt(l_x), and sqrt(alpha w_i e_i) for each vertex. Li et al. do not state
steps, damping or starting curves, so scipy's are used, a hundredth of each range for derivatives, and three starts: the
curve shipped with their code, a high arch and a low arch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from scipy.optimize import least_squares

from tatamu.base.errors import SimulationError
from tatamu.base.files import write_json
from tatamu.cli.program import run
from tatamu.folding.baselines import li_2015
from tatamu.folding.score import ALPHA, vertex_distances, weights
from tatamu.folding.task import Task, make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.search.space import Space
from tatamu.simulation.simulators import simulate

ARCHES = ((1 / 3, 0.6), (2 / 3, 0.6)), ((1 / 3, 0.2), (2 / 3, 0.2))
"""P1 and P2 of the high and the low arch, in spans."""
SEARCHED = ("x1", "x2", "z1", "z2")
DIFFERENCE = 0.01
"""Step of a derivative, in ranges of the parameters."""


class Spent(Exception):
    """Raised when all trials were made."""


@dataclass
class Li:
    """The method on one task. Each new point is a trial."""

    task: Task
    trials: int
    done: dict[tuple[float, ...], tuple[float, np.ndarray]] = field(default_factory=dict)
    """Objective C and residuals of each trial, by its point of the unit cube."""

    @property
    def space(self) -> Space:
        """The space of P1 and P2."""
        return Space({name: self.task.space.bounds[name] for name in SEARCHED})

    def parameters(self, point: np.ndarray) -> dict[str, Any]:
        """Return the parameters of a point; the first candidate of each hand is its corner."""
        grasps = {name: each.low for name, each in self.task.space.bounds.items() if name not in SEARCHED}
        return {**grasps, **self.space.parameters(point)}

    def residuals(self, point: np.ndarray) -> np.ndarray:
        """Return the residuals at the nearest point of the unit cube, shape (n + 1,).

        A trial that fails has twice the D of untouched cloth.
        """
        inside = np.clip(point, 0.0, 1.0)
        key = tuple(np.round(inside, 9).tolist())
        if key in self.done:
            return self.done[key][1]
        if len(self.done) == self.trials:
            raise Spent
        fold = self.task.fold
        manipulation = self.task.manipulation(self.parameters(inside))
        try:
            end = simulate(scene_of(fold, manipulation), self.task.simulator).positions[-1]
            errors, factor = vertex_distances(fold.target, end), 1.0
        except SimulationError:
            errors, factor = vertex_distances(fold.target, fold.start), 2.0
        found = np.sqrt([manipulation.trajectory_length, *(factor * ALPHA * weights(errors) * errors)])
        self.done[key] = float(found @ found), found
        return found

    def jacobian(self, point: np.ndarray) -> np.ndarray:
        """Return the derivatives, shape (n + 1, 4), by differences that stay in the unit cube."""
        inside = np.clip(point, 0.0, 1.0)
        steps = np.where(inside + DIFFERENCE <= 1.0, DIFFERENCE, -DIFFERENCE)
        here = self.residuals(inside)
        return np.column_stack([(self.residuals(inside + one) - here) / one.sum() for one in np.diag(steps)])

    def starts(self) -> Iterator[np.ndarray]:
        """Yield the points from which searches start, and then random ones, shape (4,)."""
        control = li_2015(self.task.fold).hands[0].control_points
        assert control is not None
        theirs = [(np.hypot(x, y) / self.task.fold.span, z / self.task.fold.span) for x, y, z in control[1:3]]
        for (x1, z1), (x2, z2) in (theirs, *ARCHES):
            values = dict(zip(SEARCHED, self.task.fold.span * np.array([x1, x2, z1, z2]), strict=True))
            yield self.space.points([values])[0]
        random = np.random.default_rng(0)
        while True:
            yield random.random(len(SEARCHED))

    def search(self) -> None:
        """Run searches, one after the other, until all trials were made."""
        try:
            for start in self.starts():
                least_squares(self.residuals, start, self.jacobian, method="lm", xtol=1e-3, ftol=1e-3)
        except Spent:
            pass


def main(
    garment: Annotated[str, typer.Argument(help="towel, tshirt or trousers.")],
    out: Annotated[Path, typer.Option(metavar="FILE.json", help="Where C and parameters of each trial go.")],
    fold: Annotated[str, typer.Option(help="A fold plan of one step.")] = "half",
    trials: Annotated[int, typer.Option(min=1)] = 50,
    simulator: Annotated[str, typer.Option(help="native, blender or mujoco.")] = "native",
) -> None:
    """Fold a garment by the method of Li et al. (2015)."""
    method = Li(make_task(garment, fold=fold, simulator=simulator), trials)
    method.search()
    rows = [
        {"objective": objective, "parameters": method.parameters(np.array(point))}
        for point, (objective, _) in method.done.items()
    ]
    write_json(out, {"garment": garment, "fold": fold, "simulator": simulator, "trials": rows})
    print(f"minimum C = {min(objective for objective, _ in method.done.values()):.4f} after {len(rows)} trials: {out}")


if __name__ == "__main__":
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(main)
    run(app, "li")
