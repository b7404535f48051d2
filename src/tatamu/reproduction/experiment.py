"""Section VI: for each garment and seed a study, one random trial first, then a Gaussian process; the best by C."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from tatamu.errors import InputError
from tatamu.folding.task import Task, make_job
from tatamu.garments import GARMENTS
from tatamu.learning import Progress, learn
from tatamu.learning.samplers import SAMPLERS
from tatamu.material import Material, load_material
from tatamu.results import LearnedFold, read_fold
from tatamu.simulators import named

FOLDS = {"towel": "half", "tshirt": "half", "trousers": "leg"}
"""What the paper's Fig. 5 shows in one fold each; its directions are lost."""
SPACING = 0.02
"""Of every mesh [m]; the paper's is lost. What Tables I and II mean depends on it."""


@dataclass(frozen=True)
class Choices:
    """What is run; where the paper says nothing, the defaults are ours. Tables are by garment."""

    simulator: str = "blender"
    garments: tuple[str, ...] = tuple(FOLDS)
    seeds: int = 5
    trials: int = 50
    sampler: str = "gp"
    sizes: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Width and length [m]; else the garment's own."""
    spacings: dict[str, float] = field(default_factory=dict)
    """[m]; else `SPACING`."""
    folds: dict[str, str] = field(default_factory=dict)
    """Else `FOLDS`."""
    materials: dict[str, str] = field(default_factory=dict)
    """Preset or file; else the preset with the paper's numbers."""

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
        if self.sampler not in SAMPLERS:
            raise InputError(f"sampler: must be one of {', '.join(SAMPLERS)}, given {self.sampler!r}")

    def material(self, garment: str) -> Material:
        """What a garment is made of."""
        return load_material(Path(self.materials.get(garment, f"paper-{garment}")))

    def task(self, garment: str) -> Task:
        """What is learned for a garment."""
        fold = self.folds.get(garment, FOLDS.get(garment, "half"))
        job = make_job(
            garment,
            size=self.sizes.get(garment),
            fold=fold,
            material=self.material(garment),
            spacing=self.spacings.get(garment, SPACING),
            simulator=self.simulator,
        )
        if len(job.plan.steps) > 1:
            raise InputError(f"--fold: {garment}={fold} has {len(job.plan.steps)} steps; give a plan of one step")
        return job.task(0)


@dataclass(frozen=True)
class Study:
    """One garment with one seed, learned."""

    garment: str
    seed: int
    fold: LearnedFold


def run(
    choices: Choices,
    folder: Path,
    progress: Callable[[str, int, Progress], None] = lambda garment, seed, progress: None,
) -> list[Study]:
    """Run all studies, or go on where they stopped.

    Args:
        choices: What is run.
        folder: Each study has a folder GARMENT/seed-N in it.
        progress: Told garment and seed with every trial.

    Raises:
        InputError: A choice is wrong, or the folder holds studies of other choices.
        TatamuError: Every trial of a study failed.
    """
    return list(_studies(choices, {garment: choices.task(garment) for garment in choices.garments}, folder, progress))


def _studies(
    choices: Choices, tasks: dict[str, Task], folder: Path, progress: Callable[[str, int, Progress], None]
) -> Iterator[Study]:
    """Seed by seed over all garments, so that something can be looked at early."""
    for seed in range(choices.seeds):
        for garment, task in tasks.items():

            def told(now: Progress, garment: str = garment, seed: int = seed) -> None:
                progress(garment, seed, now)

            where = folder / garment / f"seed-{seed}"
            learn(
                task,
                where,
                trials=choices.trials,
                seed=seed,
                sampler=choices.sampler,
                grasps="continuous",
                baselines=False,
                progress=told,
            )
            yield Study(garment, seed, read_fold(where))
