"""Section VI: for each garment and seed a study of one random trial and then a Gaussian process; the best by C."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from tatamu.errors import InputError
from tatamu.folding.task import Task, make_task
from tatamu.garments import GARMENTS
from tatamu.material import Material, load_material
from tatamu.options import LearnOptions
from tatamu.report import write_report
from tatamu.search import check_search
from tatamu.simulators import named
from tatamu.study import Places, Progress, Result, learn

FOLDS = {"towel": "half", "tshirt": "half", "trousers": "leg"}
"""Fold of each garment: Fig. 5 of the paper shows one each, but not its direction."""
SPACING = 0.02
"""Spacing of every mesh [m]; the paper does not give its own. The cloth of Tables I and II depends on it."""


@dataclass(frozen=True)
class Choices:
    """The choices of a run by garment, with defaults where the paper states nothing."""

    simulator: str = "blender"
    garments: tuple[str, ...] = tuple(FOLDS)
    seeds: int = 5
    trials: int = 50
    sampler: str = "gp"
    sizes: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Width and length [m]; default: the garment's own."""
    spacings: dict[str, float] = field(default_factory=dict)
    """Mesh spacing [m]; default: `SPACING`."""
    folds: dict[str, str] = field(default_factory=dict)
    """Fold plan; default: that of `FOLDS`."""
    materials: dict[str, str] = field(default_factory=dict)
    """Preset or file; default: the preset with the paper's numbers."""

    def __post_init__(self) -> None:
        named(self.simulator)
        for name in (*self.garments, *self.sizes, *self.spacings, *self.folds, *self.materials):
            if name not in GARMENTS:
                raise InputError(f"garment: must be one of {', '.join(GARMENTS)}, given {name!r}")
        for word, value, most in (("--seeds", self.seeds, 100), ("--trials", self.trials, 10_000)):
            if not 1 <= value <= most:
                raise InputError(f"{word}: must be from 1 to {most}, given {value}")
        if not self.garments or len(set(self.garments)) < len(self.garments):
            raise InputError(
                f"--garments: must be one or more different ones, given {','.join(self.garments) or 'none'}"
            )
        check_search(self.sampler)

    def material(self, garment: str) -> Material:
        """Return the material of a garment."""
        return load_material(Path(self.materials.get(garment, f"paper-{garment}")))

    def task(self, garment: str) -> Task:
        """Return the task of a garment."""
        fold = self.folds.get(garment, FOLDS.get(garment, "half"))
        task = make_task(
            garment,
            size=self.sizes.get(garment),
            fold=fold,
            material=self.material(garment),
            spacing=self.spacings.get(garment, SPACING),
            simulator=self.simulator,
        )
        if len(task.plan.steps) > 1:
            raise InputError(f"--fold: {garment}={fold} has {len(task.plan.steps)} steps; give a plan of one step")
        return task


@dataclass(frozen=True)
class Study:
    """The learned fold of one garment and seed."""

    garment: str
    seed: int
    fold: Result


def run(
    choices: Choices,
    folder: Path,
    progress: Callable[[str, int, Progress], None] = lambda garment, seed, progress: None,
    executor: Executor | None = None,
    at_a_time: int = 1,
) -> list[Study]:
    """Run all studies, or resume them.

    Args:
        choices: Garments, seeds, trials and everything that the paper leaves open.
        folder: Folder in which each study has a folder GARMENT/seed-N.
        progress: Function that is called with garment and seed for every trial.
        executor: Executor on which trials run; None to run them here.
        at_a_time: Number of studies at a time; the trials of a study are sequential, as in the paper.

    Raises:
        InputError: If a choice is wrong, or the folder contains studies of other choices.
        TatamuError: If every trial of a study failed.
    """
    tasks = {garment: choices.task(garment) for garment in choices.garments}
    wanted = [(garment, seed) for seed in range(choices.seeds) for garment in tasks]  # every garment early

    def study(garment: str, seed: int) -> Study:
        where = folder / garment / f"seed-{seed}"
        options = LearnOptions(
            trials=choices.trials,
            seed=seed,
            sampler=choices.sampler,
            grasps="continuous",
            disturbances="none",
            coarse=False,
            baselines=False,
            parallel=1,  # as in the paper, each trial knows all before it
        )
        places = Places(
            out=where,
            executor=executor,
            progress=lambda now: progress(garment, seed, now),
            written=write_report,  # type: ignore[arg-type]
        )
        return Study(garment, seed, learn(tasks[garment], options, places))  # type: ignore[arg-type]

    if at_a_time == 1:
        return [study(garment, seed) for garment, seed in wanted]
    with ThreadPoolExecutor(at_a_time) as pool:
        futures = [pool.submit(study, garment, seed) for garment, seed in wanted]
        try:
            return [future.result() for future in futures]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            if executor is not None:
                executor.shutdown(wait=False, cancel_futures=True)  # those who wait for trials hear of it
            raise
