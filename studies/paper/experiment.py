"""Runs the studies of section VI of the paper: one study for each garment and random seed.

A study has one random trial, and then trials that a Gaussian process proposes. Its result is the trial with the lowest
objective C.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.folding.task import Task, make_task
from tatamu.garments import GARMENTS
from tatamu.search import check_search
from tatamu.simulation.material import Material, load_material
from tatamu.simulation.simulators import named
from tatamu.study.learn import learn
from tatamu.study.loop import Progress
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

FOLDS = {"towel": "half", "tshirt": "half", "trousers": "leg"}
"""Fold plan that is learned for each garment. Fig. 5 of the paper shows a fold for each garment, but does not show the
direction of the fold."""
SPACING = 0.02
"""Edge length ("spacing") of every mesh [m]. The paper does not state this length, although the properties of the cloth
in Tables I and II depend on it."""


@dataclass(frozen=True)
class Choices:
    """The choices of a run of the paper's experiment.

    Choices that the paper does not state have default values.
    """

    simulator: str = "blender"
    garments: tuple[str, ...] = tuple(FOLDS)
    seeds: int = 5
    trials: int = 50
    sampler: str = "gp"
    sizes: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Width and length of each garment [m], by the garment's name. The default is the garment's default size."""
    spacings: dict[str, float] = field(default_factory=dict)
    """Edge length of the mesh of each garment [m], by the garment's name. The default is `SPACING`."""
    folds: dict[str, str] = field(default_factory=dict)
    """Fold plan of each garment, by the garment's name. The default is from `FOLDS`."""
    materials: dict[str, str] = field(default_factory=dict)
    """Material preset or file of each garment, by the garment's name. The default is the preset with the paper's
    numbers."""

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
        """Return the material of the cloth of a garment."""
        return load_material(Path(self.materials.get(garment, f"paper-{garment}")))

    def task(self, garment: str) -> Task:
        """Return the folding task of a garment."""
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
    """The result of a study: the learned fold, with its garment and the random seed of the search."""

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
    """Run or resume a study for each garment and random seed.

    Args:
        choices: Garments, seeds, trials and everything that the paper leaves open.
        folder: Folder in which each study has a folder GARMENT/seed-N.
        progress: Function that is called at every trial, with the garment, the seed and the progress.
        executor: Executor on which trials run; None to run them in this process.
        at_a_time: Number of studies that run at a time. The trials of a study run one after the other, as in the paper.

    Raises:
        InputError: If a choice is wrong, or the folder contains studies with other choices.
        TatamuError: If every trial of a study failed.
    """
    tasks = {garment: choices.task(garment) for garment in choices.garments}
    wanted = [(garment, seed) for seed in range(choices.seeds) for garment in tasks]  # all garments of a seed first

    def study(garment: str, seed: int) -> Study:
        where = folder / garment / f"seed-{seed}"
        options = LearnOptions(
            trials=choices.trials,
            seed=seed,
            sampler=choices.sampler,
            grasps="continuous",
            disturbances="none",
            baselines=False,
            parallel=1,  # as in the paper, each proposal uses all earlier trials
        )
        result = learn(
            tasks[garment], options, out=where, executor=executor, progress=lambda now: progress(garment, seed, now)
        )
        assert isinstance(result, Result), "the paper's plans have one step"
        return Study(garment, seed, result)

    if at_a_time == 1:
        return [study(garment, seed) for garment, seed in wanted]
    with ThreadPoolExecutor(at_a_time) as pool:
        futures = [pool.submit(study, garment, seed) for garment, seed in wanted]
        try:
            return [future.result() for future in futures]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            if executor is not None:
                executor.shutdown(wait=False, cancel_futures=True)  # ends the waiting for trials
            raise
