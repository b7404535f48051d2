"""The feedback of a real fold: the inferred errors of the set-up, and the correction of the next fold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from tatamu.after.feedback.correction import Correction, as_disturbances, find_correction
from tatamu.after.feedback.emulator import Emulator, fit
from tatamu.after.feedback.folder import FeedbackFolder
from tatamu.after.feedback.measured import MeasuredFold
from tatamu.after.feedback.posterior import IMPLAUSIBLE, Fold, Posterior, posterior
from tatamu.after.margins.measurement import KEPT
from tatamu.base.errors import InputError
from tatamu.base.files import write_json
from tatamu.evaluation.disturbances import Disturbances, Stream, mean_scenario, sample_scenarios, split
from tatamu.evaluation.draws import Draws, Progress, Subject
from tatamu.folding.manipulation import HandShift
from tatamu.simulation.side_by_side import executor_of, processors
from tatamu.simulation.simulators import capabilities
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result

SCENARIOS = 100
"""Number of scenarios: the first draws of `tatamu margins`."""


@dataclass(frozen=True)
class Feedback:
    """The measured folds of a set-up, the posterior of its errors, and the next correction."""

    learned: Result
    """The fold as it was learned."""
    folds: list[Fold]
    """The measured folds in order."""
    emulator: Emulator
    subject: Subject
    """The manipulation that was simulated in scenarios."""
    scenarios: int
    """How many scenarios were simulated."""
    files: list[Path] = field(default_factory=list)
    """The file of each measured fold; empty if the learned fold has no folder."""
    newest: int = -1
    """Index in `folds` of the fold that was measured last."""

    def __repr__(self) -> str:
        before, after = (1e3 * each.distance for each in (self.correction.before, self.correction.after))
        return (
            f"<Observed folds of {self.learned.name}: {len(self.folds)}; the next is expected {before:.1f} mm from the "
            f"target, {after:.1f} mm after the correction>"
        )

    @property
    def disturbances(self) -> Disturbances:
        """The disturbances before any fold was measured."""
        return self.learned.disturbances

    @cached_property
    def posterior(self) -> Posterior:
        """The posterior of the set-up's systematic errors."""
        return posterior(self.disturbances, self.folds)

    @cached_property
    def correction(self) -> Correction:
        """The correction of the next fold."""
        return find_correction(self.posterior, self.emulator, self.learned)

    @property
    def implausible(self) -> list[int]:
        """Places of the implausible measured folds, counted from 1."""
        return [place for place, chance in enumerate(self.posterior.chances, start=1) if chance < IMPLAUSIBLE]

    def with_fold(self, place: int, file: Path, fold: Fold) -> Feedback:
        """Return the feedback with one more measured fold, inserted at an index."""
        folds, files = ([*each[:place], new, *each[place:]] for each, new in ((self.folds, fold), (self.files, file)))
        return replace(self, folds=folds, files=files, newest=place)

    def fold(self, shift: Sequence[HandShift], measured: MeasuredFold) -> Fold:
        """Return a measured fold that was carried out with a shift of each hand."""
        change = as_disturbances(shift, self.learned.task.shift)
        return Fold(measured, self.emulator, self.emulator.moved(change))


def observe(
    learned: Result,
    measured: MeasuredFold | None = None,
    *,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
    show: Callable[[Feedback, Path], None] = lambda found, file: None,
) -> Feedback:
    """Return what all measured folds of a set-up tell, and write it into the folder of the learned fold, if it has one.

    The measured fold is written last, so that an interrupted call can be repeated without counting the fold twice.

    Args:
        learned: The fold as it was carried out, with its correction if it had one.
        measured: The measured fold; None to use only earlier ones.
        executor: Executor of the simulations; None for threads on all processors.
        progress: Function that is called after every simulation.
        show: Function that writes pages and pictures. It receives the feedback and the file of the measured fold, which
            is written afterwards.

    Raises:
        InputError: If no fold was measured, or the method does not support this fold.
    """
    folder = None if learned.folder is None else FeedbackFolder.of(learned.folder)
    if measured is None:
        if folder is None or learned.folder is None:
            raise InputError("fold: has not been measured yet; call `observe` with measured numbers first")
        folder.require_measured(learned.folder)
    base = learned if folder is None or folder.path == learned.folder else Result.load(folder.path)
    found = feedback_of(base, folder, executor, progress)
    file = Path() if folder is None or learned.folder is None else folder.next_file(learned.folder)
    if measured is not None:
        place = 0 if folder is None else folder.index_of(file)
        found = found.with_fold(place, file, found.fold(learned.task.shift, measured))
    if folder is not None:
        folder.write_posterior(found.posterior.disturbances)
        show(found, file)
        if measured is not None:
            write_json(file, measured.model_dump())
    return found


def feedback_of(
    base: Result,
    folder: FeedbackFolder | None,
    executor: Executor | None = None,
    progress: Progress = lambda done, total: None,
) -> Feedback:
    """Return what the measured folds in a folder tell. Missing scenarios are simulated.

    `base` is the fold as it was learned; `folder` is None if it is only in memory.
    """
    disturbances = base.disturbances
    subject = Subject(replace(base.task, reach=None), base.best.parameters)
    scenarios = [mean_scenario(disturbances), *sample_scenarios(disturbances, SCENARIOS, 0, Stream.MARGINS)]
    kept = None if folder is None else ResultFolder(folder.path).margins_folder / KEPT  # `tatamu margins` shares them
    threads = processors() if capabilities(subject.task.simulator).parallel else 1
    with executor_of(executor, threads) as workers:
        outcomes = Draws(subject, workers, kept, progress).outcomes(scenarios)
    emulator = fit(split(disturbances), list(zip(scenarios, outcomes, strict=True)))
    found = Feedback(base, [], emulator, subject, len(scenarios))
    known = [] if folder is None else folder.measured()
    shifts = [  # with which the fold of each folder was carried out
        base.task.shift if path == base.folder else ResultFolder(path).record.task.shift or () for path, _ in known
    ]
    folds = [found.fold(shift, measured) for shift, (_, measured) in zip(shifts, known, strict=True)]
    return replace(found, folds=folds, files=[] if folder is None else folder.files())
