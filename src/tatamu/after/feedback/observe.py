"""Observation of a real fold: simulated draws, inferred errors of the set-up, and correction of the next fold."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tatamu.after.feedback.correction import Correction, as_disturbances, find_correction
from tatamu.after.feedback.draws import Draws, Progress, draw
from tatamu.after.feedback.emulator import Emulator, Inputs, fit
from tatamu.after.feedback.folder import ObservedFolder
from tatamu.after.feedback.measured import Observation
from tatamu.after.feedback.posterior import IMPLAUSIBLE, Fold, Posterior, posterior
from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Disturbances, World, default_disturbances, hand_errors, split
from tatamu.folding.shift import HandShift
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result

BEYOND = "beyond everything that was drawn: check the grasp or the scale, look again; it is left out"


@dataclass(frozen=True)
class Observed:
    """All observed folds of a set-up, the posterior of its errors, and the next correction.

    A set-up is one robot with one garment on one table. Its errors are disturbances of the fold, such as errors of the
    hands' positions. The posterior is the distribution of these errors after the folds were observed.
    """

    learned: Result
    """The fold as it was learned."""
    folds: list[Fold]
    """The observed folds in order."""
    emulator: Emulator
    draws: Draws
    posterior: Posterior
    correction: Correction
    """Correction of the next fold."""
    newest: int
    """Index in `folds` of the fold that was observed last."""

    def __repr__(self) -> str:
        before, after = (1e3 * each.distance for each in (self.correction.before, self.correction.after))
        return (
            f"<Observed folds of {self.learned.name}: {len(self.folds)}; the next is expected {before:.1f} mm from the "
            f"target, {after:.1f} mm after the correction>"
        )

    @property
    def number(self) -> int:
        """Number of observed folds."""
        return len(self.folds)

    @property
    def implausible(self) -> list[int]:
        """Numbers of the implausible observed folds, counted from 1.

        They deviate more than nearly all simulated draws.
        """
        chances = enumerate(self.posterior.chances, start=1)
        return [number for number, chance in chances if chance < IMPLAUSIBLE]


def disturbances_of(learned: Result) -> Disturbances:
    """Return the disturbances in which a fold was learned.

    If it was learned without, return the default disturbances.
    """
    held = learned.record.disturbances
    return default_disturbances() if held is None else Disturbances.model_validate(held)


def observe(
    learned: Result,
    observation: Observation | None = None,
    *,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Observed:
    """Observe a real fold, and return the posterior of all observed folds of the set-up.

    A set-up is one robot with one garment on one table. Its errors are disturbances of the fold, such as errors of the
    hands' positions. The posterior is the distribution of these errors after the folds were observed. If the fold has a
    folder, simulations are saved there, the observation is added to earlier observations, and `posterior.toml` is
    written. Without a folder, the given observation is the only one.

    Args:
        learned: The fold as it was carried out. It contains its correction, if it had one.
        observation: The measurement; None to use only earlier observations.
        executor: Executor of the simulations; None for threads on all processors.
        progress: Function that is called after every simulation.

    Raises:
        InputError: If nothing was observed, or the method does not support this fold.
    """
    folder = None if learned.folder is None else ObservedFolder.of(learned.folder)
    base = learned if folder is None or folder.path == learned.folder else Result.load(folder.path)
    if observation is None and (folder is None or not folder.observations()):
        raise InputError("observation: must have numbers, as nothing was observed before; give left, right or slip")
    evidence = evidence_of(base, folder, executor, progress)
    folds = list(evidence.folds)
    newest = len(folds) - 1
    if observation is not None:
        newest = len(folds) if folder is None else folder.place_of_next(learned.folder or folder.path)
        folds.insert(newest, evidence.fold(learned.task.shift, observation))
    found = posterior(evidence.disturbances, folds)
    correction = find_correction(found, evidence.emulator, base.task.fold, base.manipulation)
    if folder is not None:
        if observation is not None:
            folder.add(learned.folder or folder.path, observation)
        folder.write_posterior(found.disturbances)
    return Observed(base, folds, evidence.emulator, evidence.draws, found, correction, newest)


@dataclass(frozen=True)
class Evidence:
    """The emulator (statistical model) of a learned fold, and the observed folds."""

    base: Result
    disturbances: Disturbances
    """The disturbances before any observation."""
    draws: Draws
    emulator: Emulator
    folds: list[Fold]

    def fold(self, shift: Sequence[HandShift], observation: Observation) -> Fold:
        """Return an observed fold that was carried out with a shift of each hand."""
        change = as_disturbances(shift, self.base.task.shift)
        return Fold(observation, self.emulator, self.emulator.moved(change))


def evidence_of(
    base: Result,
    folder: ObservedFolder | None,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Evidence:
    """Return the emulator and the observations of a learned fold. Missing draws are simulated.

    Args:
        base: The fold as it was learned, without a correction.
        folder: Folder of the fold; None if the fold is only in memory.
        executor: Executor of the simulations; None for threads on all processors.
        progress: Function that is called after every simulation.
    """
    disturbances = disturbances_of(base)
    kept = None if folder is None else ResultFolder(folder.path).margins_folder
    draws = draw(base, disturbances, kept, executor, progress)
    found = Evidence(base, disturbances, draws, emulator_of(base, disturbances, draws), [])
    known = [] if folder is None else folder.observations()
    return replace(found, folds=[found.fold(shift_of(path, base), observation) for path, observation in known])


def emulator_of(base: Result, disturbances: Disturbances, draws: Draws) -> Emulator:
    """Return the emulator (statistical model) of a fold, fitted to its draws."""
    parts = split(disturbances)
    scale = np.where(parts.deviations > 0.0, parts.deviations, 1.0)
    laid = np.array([_laid(base, name) for name in parts.names])
    return fit(Inputs(parts.names, parts.mean, scale, laid), draws.worlds, draws.difference)


def _laid(base: Result, name: str) -> np.ndarray:
    """Return the place at which each hand alone would lay the hem down, per unit of a disturbance, shape (hands, 2)."""
    small = 1e-4
    errors = hand_errors(base.task.fold, base.manipulation, World({name: small}))
    return np.array([hand[:2] - [0.0, grasp[1]] for grasp, hand in errors]) / small


def shift_of(path: Path, base: Result) -> tuple[HandShift, ...]:
    """Return the correction of each hand with which the fold of a folder was carried out."""
    if path == base.folder:
        return base.task.shift
    return tuple(ResultFolder(path).record.task.shift or ())
