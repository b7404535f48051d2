"""Observing a fold: draws of the simulator, the posterior given all observed folds, and the correction of the next."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tatamu.disturbances import Disturbances, default_disturbances, disturbed_scene, split
from tatamu.errors import InputError
from tatamu.files import write_json
from tatamu.folding.shift import HandShift
from tatamu.observation.correction import Correction, added, as_disturbances, find_correction
from tatamu.observation.draws import Draws, Progress, draw
from tatamu.observation.emulator import Emulator, fit
from tatamu.observation.folder import ObservedFolder
from tatamu.observation.measured import Observation
from tatamu.observation.posterior import IMPLAUSIBLE, Fold, Posterior, posterior
from tatamu.study import Result, ResultFolder

BEYOND = "beyond everything that was drawn: check the grasp or the scale; nothing is corrected after it"


@dataclass(frozen=True)
class Observed:
    """All observed folds of a set-up, their posterior, and the correction that follows."""

    learned: Result
    """The fold as it was learned."""
    folds: list[Fold]
    """The observed folds in order."""
    emulator: Emulator
    draws: Draws
    posterior: Posterior
    correction: Correction
    """Correction of the next fold."""

    @property
    def number(self) -> int:
        """Number of observed folds."""
        return len(self.folds)

    @property
    def implausible(self) -> list[int]:
        """Numbers of the observed folds, from 1, that are beyond everything that was drawn."""
        chances = enumerate(self.posterior.chances, start=1)
        return [number for number, chance in chances if chance < IMPLAUSIBLE]


def disturbances_of(learned: Result) -> Disturbances:
    """Return the disturbances in which a fold was learned, or the default ones."""
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

    With a folder, simulations are kept, the observation is added to earlier ones, and `posterior.toml` is written.
    Without a folder, it is the only observation.

    Args:
        learned: The fold as it was carried out, with its correction if it had one.
        observation: The measurement; None to use earlier ones only.
        executor: Where simulations run; None for threads on every processor.
        progress: Called after every simulation.

    Raises:
        InputError: If nothing was observed, or the fold cannot be learned from.
    """
    folder = None if learned.folder is None else ObservedFolder.of(learned.folder)
    base = learned if folder is None or folder.path == learned.folder else Result.load(folder.path)
    if observation is None and (folder is None or not folder.observations()):
        raise InputError("observation: must have numbers, as nothing was observed before; give left, right or slip")
    evidence = evidence_of(base, folder, executor, progress)
    folds = [*evidence.folds, *([evidence.fold(learned.task.shift, observation)] if observation else [])]
    found = posterior(evidence.disturbances, folds)
    correction = find_correction(found, evidence.emulator, base.task.fold, base.manipulation)
    if folder is not None:
        if observation is not None:
            folder.add(learned.folder or folder.path, observation)
        folder.write_posterior(found.disturbances)
    return Observed(base, folds, evidence.emulator, evidence.draws, found, correction)


@dataclass(frozen=True)
class Evidence:
    """The emulator of a learned fold, and its observed folds."""

    base: Result
    disturbances: Disturbances
    """The disturbances before any observation."""
    draws: Draws
    emulator: Emulator
    folds: list[Fold]

    def fold(self, shift: Sequence[HandShift], observation: Observation) -> Fold:
        """Return an observed fold that was carried out with a shift of its hands."""
        change = as_disturbances(shift, self.base.task.shift)
        return Fold(observation, self.emulator, self.emulator.moved(change))


def evidence_of(
    base: Result,
    folder: ObservedFolder | None,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Evidence:
    """Return the evidence on a learned fold; missing draws are simulated.

    Args:
        base: The fold as it was learned.
        folder: Its folder; None if it is in memory only.
        executor: Where simulations run; None for threads on every processor.
        progress: Called after every simulation.
    """
    disturbances = disturbances_of(base)
    kept = None if folder is None else ResultFolder(folder.path).margins_folder
    draws = draw(base, disturbances, kept, executor, progress)
    found = Evidence(base, disturbances, draws, emulator_of(disturbances, draws), [])
    known = [] if folder is None else folder.observations()
    return replace(found, folds=[found.fold(shift_of(path, base), observation) for path, observation in known])


def emulator_of(disturbances: Disturbances, draws: Draws) -> Emulator:
    """Return the emulator of a fold, fitted to its draws."""
    parts = split(disturbances)
    scale = np.where(parts.deviations > 0.0, parts.deviations, 1.0)
    return fit(parts.names, parts.mean, scale, draws.worlds, draws.difference)


def shift_of(path: Path, base: Result) -> tuple[HandShift, ...]:
    """Return the correction with which the fold of a folder was carried out."""
    if path == base.folder:
        return base.task.shift
    return tuple(ResultFolder(path).record.task.shift or ())


def write_corrected(observed: Observed, out: Path | None = None) -> Result:
    """Write the folder of the corrected fold, which robot plans take, and return the fold.

    Its rollout is that of the learned fold, which the correction aims at. Its scene has the corrected hands with their
    expected errors.

    Args:
        observed: What was observed.
        out: The folder; None for `corrected-N` in the folder of the learned fold.

    Raises:
        InputError: If the learned fold has no folder and none is given, or the folder cannot be written.
    """
    made = corrected(observed)
    folder = observed.learned.folder
    if out is None and folder is None:
        raise InputError("out: must be given, as the learned fold has no folder")
    path = out or ObservedFolder(folder or Path()).corrected(observed.number)
    made.save(path)
    write_json(path / "correction.json", plain_correction(observed))
    return replace(made, folder=path)


def corrected(observed: Observed) -> Result:
    """Return the learned fold with the correction after all observed folds."""
    learned, found = observed.learned, observed.posterior
    task = replace(learned.task, shift=added(learned.task.shift, observed.correction.shifts))
    manipulation = task.manipulation(learned.best.parameters)
    description = learned.record.task.model_copy(update={"shift": list(task.shift) or None})
    record = learned.record.model_copy(
        update={"task": description, "disturbances": found.disturbances.describe(), "judged": None}
    )
    scene = disturbed_scene(task.fold, manipulation, found.world)
    return Result(record, manipulation, scene, learned.rollout, None, task)


def plain_correction(observed: Observed) -> dict[str, object]:
    """Return the content of `correction.json`."""
    correction = observed.correction
    hands: Sequence[HandShift] = correction.shifts
    return {
        "version": 1,
        "observed": observed.number,
        "hands": [shift.model_dump() for shift in hands],
        "expected": {"before": correction.before.plain(), "after": correction.after.plain()},
    }
