"""What the size of scenarios and the spacing of meshes change: two tables of docs/notes/margins.md.

    python -m benchmarks.scenarios --out runs/scenarios [--seeds 1] [--only levels] [--write-docs]

A file of the folder keeps what each study found, and each verdict; to resume, repeat the command.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from statistics import median
from typing import Any
from unittest.mock import patch

from benchmarks.gains import CASES, DRAWS, UNUSED_SEED, in_fresh_scenarios, ranged, simulations_of
from benchmarks.tables import arguments, kept, show
from tatamu.evaluation.array import LEVEL
from tatamu.evaluation.disturbances import Scenario, Stream, default_disturbances, disturbed_scene, sample_scenarios
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.scenarios import Scenarios, array_scenarios
from tatamu.folding.parameters import arched_inwards
from tatamu.folding.score import Limits, score
from tatamu.simulation.mesh.meshing import before_subdivision, subdivided
from tatamu.simulation.side_by_side import processors
from tatamu.simulation.simulators import simulate
from tatamu.study.learn import learn
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

STUDIES = [(1.0, False), (LEVEL, False), (2.0, False), (3.0, False), (LEVEL, True)]
"""Levels of the scenarios of the towel, and whether the array is folded over."""
MESH_DRAWS = {"towel": 100, "tshirt": 25, "leg": 25}
"""How many scenarios are simulated on both meshes."""


@dataclass(frozen=True)
class FoldOver(Scenarios):
    """Scores a fold over the scenarios of an array and their mirror images."""

    @cached_property
    def sample(self) -> list[Scenario]:
        return [each for sign in (1, -1) for each in array_scenarios(self.disturbances, sign * self.level)]


def study(level: float, folded_over: bool, seed: int) -> dict[str, Any]:
    """Learn a fold, and simulate it in fresh scenarios."""
    task = CASES["towel"].task()
    with patch("tatamu.study.learn.Scenarios", FoldOver if folded_over else Scenarios):
        result = learn(task, LearnOptions(seed=seed, level=level, baselines=False))
    assert isinstance(result, Result), "this plan has one step"
    success = in_fresh_scenarios(task, result.best.parameters)
    path = result.record.best_score.trajectory_length
    return {"path": path, "succeeded": success.succeeded, "simulations": simulations_of(result)}


def levels(out: Path, seeds: int) -> list[dict[str, str]]:
    """Return a row for each size of the scenarios."""
    table = []
    for level, folded_over in STUDIES:
        name = f"{level:.1f} deviations" + (", with the fold-over array" if folded_over else "")
        files = [out / f"towel-{level:g}-{folded_over:d}-{seed}.json" for seed in range(seeds)]
        found = [kept(file, partial(study, level, folded_over, seed)) for seed, file in enumerate(files)]
        table.append(
            {
                "fold": CASES["towel"].name,
                "scenarios": name,
                "seeds": str(seeds),
                "path [m]": ranged([each["path"] for each in found], 3),
                f"succeeds, of {DRAWS} simulations": ranged([each["succeeded"] for each in found], 0),
                "simulations": ranged([each["simulations"] for each in found], 0),
            }
        )
    return table


def verdicts(case: str, index: int) -> list[float | None]:
    """Return the mean distance from the target on the mesh and on one of half its spacing, None if it fails [m]."""
    task = CASES[case].task()
    fold, manipulation = task.fold, task.manipulation(arched_inwards(task.fold))
    scenario = sample_scenarios(default_disturbances(), index + 1, UNUSED_SEED, Stream.MARGINS)[index]
    found = Nominal(task).fixed(manipulation, scenario)
    if found.rollout is None:
        return [None, None]
    fine = simulate(subdivided(disturbed_scene(fold, manipulation, scenario)), task.simulator)
    ends = [found.rollout.positions[-1], before_subdivision(fine, found.rollout.faces).positions[-1]]
    scores = [score(fold, 0.0, end) for end in ends]
    return [each.mean_vertex_distance if Limits().hold(each) else None for each in scores]


def meshes(out: Path) -> list[dict[str, str]]:
    """Return a row for each garment: how often its mesh and one of half its spacing come to the same verdict."""
    table = []
    with ThreadPoolExecutor(processors()) as workers:
        for case, draws in MESH_DRAWS.items():
            files = [out / f"mesh-{case}-{index}.json" for index in range(draws)]
            jobs = [workers.submit(kept, file, partial(verdicts, case, i)) for i, file in enumerate(files)]
            found = [job.result() for job in jobs]
            same = sum((one is None) == (other is None) for one, other in found)
            both = [1e3 * abs(one - other) for one, other in found if one is not None and other is not None]
            task = CASES[case].task()
            table.append(
                {
                    "fold": CASES[case].name,
                    "spacing [mm]": f"{1e3 * task.garment.spacing:.0f}",
                    "vertices": str(len(task.fold.start)),
                    "same verdict with half the spacing": f"{same} of {draws}",
                    "difference of mean distances [mm]": f"{median(both):.1f}, at most {max(both):.1f}",
                }
            )
    return table


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--only", choices=["levels", "meshes"])
    options = parser.parse_args()
    for name in [options.only] if options.only else ["meshes", "levels"]:
        rows = levels(options.out, options.seeds) if name == "levels" else meshes(options.out)
        show({f"scenarios: {name}": rows}, options.write_docs)


if __name__ == "__main__":
    main()
