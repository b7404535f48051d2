"""The corrected fold: the record of its correction, and its folder, from which robot plans are made.

`tatamu observe` saves the record of the next correction, so `tatamu correct` need not compute the correction again.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from tatamu.after.feedback.correction import Expected, added
from tatamu.after.feedback.folder import ObservedFolder
from tatamu.after.feedback.observe import Observed
from tatamu.base.errors import InputError
from tatamu.base.files import read_json, write_json
from tatamu.base.records import OpenRecord
from tatamu.evaluation.disturbances import Disturbances, disturbed_scene, mean_world, read_disturbances
from tatamu.folding.shift import HandShift
from tatamu.simulation.material import Number
from tatamu.study.result import Result

FILE = "correction.json"


class End(OpenRecord):
    """The expected outcome of the next fold."""

    mean_vertex_distance: Number
    """Mean vertex distance [m]."""
    interval: Annotated[list[Number], Field(min_length=2, max_length=2)]
    """90 % interval of the mean vertex distance [m]."""
    marks: dict[str, Number]
    """Means of the six marks, the lengths that are measured after a fold [m]."""

    @classmethod
    def of(cls, expected: Expected) -> End:
        """Return the record of an expected outcome."""
        return cls.model_validate(expected.plain())


class CorrectionRecord(OpenRecord):
    """The file `correction.json`."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"after"})

    version: Literal[1] = 1
    observed: int
    """Number of observed folds."""
    hands: list[HandShift]
    """Shift of each hand, left before right; empty if no shift is expected to help."""
    expected: dict[Literal["before", "after"], End]
    """Expected outcomes of the next fold, without the correction and with it."""
    after: str = ""
    """Digest of the observations from which the correction was computed."""

    @classmethod
    def of(cls, observed: Observed) -> CorrectionRecord:
        """Return the record of the correction that follows from observed folds."""
        correction = observed.correction
        return cls(
            observed=observed.number,
            hands=[] if correction.is_none else list(correction.shifts),
            expected={"before": End.of(correction.before), "after": End.of(correction.after)},
        )


def keep(observed: Observed) -> None:
    """Write the record of the next correction into the folder of the observations."""
    folder = ObservedFolder.of(observed.learned.folder or Path())
    record = CorrectionRecord.of(observed).model_copy(update={"after": folder.digest})
    write_json(folder.correction_file, record.model_dump())


def kept(folder: ObservedFolder) -> CorrectionRecord | None:
    """Return the saved record of the next correction; None if no record was saved for exactly these observations."""
    try:
        record = CorrectionRecord.model_validate(read_json(folder.correction_file))
    except (InputError, ValueError):
        return None
    return record if record.after == folder.digest else None


def corrected(learned: Result, record: CorrectionRecord, disturbances: Disturbances) -> Result:
    """Return a learned fold with a correction.

    Args:
        learned: The fold as it was learned.
        record: The correction.
        disturbances: The posterior, which is the distribution of the errors after the observed folds.
    """
    task = replace(learned.task, shift=added(learned.task.shift, tuple(record.hands)))
    manipulation = task.manipulation(learned.best.parameters)
    description = learned.record.task.model_copy(update={"shift": list(task.shift) or None})
    plain = learned.record.model_copy(
        update={"task": description, "disturbances": disturbances.describe(), "judged": None}
    )
    scene = disturbed_scene(task.fold, manipulation, mean_world(disturbances))
    return Result(plain, manipulation, scene, learned.rollout, None, task)


def write_corrected(observed: Observed, out: Path | None = None) -> Result:
    """Write the folder of the fold that is corrected after observed folds, and return the fold. See `write`."""
    return write(observed.learned, CorrectionRecord.of(observed), observed.posterior.disturbances, out)


def write_kept(folder: ObservedFolder, record: CorrectionRecord, out: Path | None = None) -> Result:
    """Write the folder of the fold with a saved correction, and return the fold. See `write`."""
    return write(Result.load(folder.path), record, read_disturbances(folder.posterior_file), out)


def write(learned: Result, record: CorrectionRecord, disturbances: Disturbances, out: Path | None = None) -> Result:
    """Write the folder of a corrected fold, from which robot plans are made, and return the fold.

    The corrected real fold should end like the learned fold in the simulation. Therefore the folder contains the
    rollout of the learned fold. The scene in the folder contains the corrected hands with their expected errors.

    Args:
        learned: The fold as it was learned.
        record: The correction.
        disturbances: The posterior, which is the distribution of the errors after the observed folds.
        out: The folder; None for `corrected-N` in the folder of the learned fold.

    Raises:
        InputError: If the learned fold has no folder and `out` is None, or the folder cannot be written.
    """
    if out is None and learned.folder is None:
        raise InputError("out: must be given, as the learned fold has no folder")
    path = out or ObservedFolder(learned.folder or Path()).corrected(record.observed)
    made = corrected(learned, record, disturbances)
    made.save(path)
    write_json(path / FILE, record.model_copy(update={"after": ""}).model_dump())
    return replace(made, folder=path)
