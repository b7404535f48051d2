"""The options of `tatamu learn` as a record, which the tasks of a sweep have too, and what is learned from them."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import ConfigDict, Field

from tatamu.cli.size import parse_size
from tatamu.errors import InputError
from tatamu.records import Record

if TYPE_CHECKING:
    from tatamu.disturbances import Disturbances
    from tatamu.folding.task import Job, Reach
    from tatamu.learning import Expectation
    from tatamu.learning.database import SharedDatabase
    from tatamu.learning.job import Reporting

Whole = Annotated[int, Field(strict=True)]
YesNo = Annotated[bool, Field(strict=True)]


class LearnOptions(Record):
    """The garment, the fold and the search as a user gives them; names and defaults are those of `tatamu learn`."""

    model_config = ConfigDict(allow_inf_nan=True)  # what makes garments says what is wrong with such numbers

    garment: str
    size: str | None = None
    scale: float | None = None
    fold: str = "half"
    hands: Whole | None = None
    material: str | None = None
    spacing: float | None = None
    simulator: str = "native"
    sampler: str = "gp"
    grasps: str = "integer"
    trials: Whole | Literal["auto"] = 50
    seed: Whole = 0
    parallel: Whole | None = None
    coarse: YesNo | None = None
    disturbances: str | None = None
    quantile: float | Literal["mean"] | None = None
    robot: str | None = None
    baselines: YesNo = True

    @property
    def most_trials(self) -> int:
        """How many trials a study may have in the end."""
        from tatamu.learning.schedule import Schedule

        return Schedule(self.trials, 1).most

    def expectation(self, out: Path | None = None, database: SharedDatabase | None = None) -> Expectation | None:
        """The expectation: as the study began in the folder `out`, or as given; not yet for a calibrated material.

        Raises:
            InputError: An option is wrong.
        """
        begun, held = self._held(out, database)
        return held if begun else self._given()

    def _held(self, out: Path | None, database: SharedDatabase | None) -> tuple[bool, Expectation | None]:
        """Whether a study that began says what is not known, as no option does, and what it says."""
        from tatamu.learning import as_begun

        if out is None or self.disturbances is not None or self.quantile is not None:
            return False, None
        return as_begun(out, database)

    def _given(self) -> Expectation | None:
        """The expectation of the options alone."""
        from tatamu.learning import USUAL_QUANTILE, Expectation

        chosen = self._disturbances()
        if chosen is None and self.quantile is not None:
            raise InputError("quantile: is of the objective in disturbed worlds, and --disturbances none has none")
        if chosen is None:
            return None
        usual = USUAL_QUANTILE if self.quantile is None else self.quantile
        return Expectation(chosen, None if usual == "mean" else usual)

    def _disturbances(self) -> Disturbances | None:
        """The disturbances that were asked for, the robot's own, or the usual ones; None: none are wanted."""
        from tatamu.disturbances import load_disturbances

        own = None
        if self.disturbances is None and self.robot is not None and self.robot.endswith(".toml"):
            from tatamu.robots.description import disturbances_of

            own = disturbances_of(Path(self.robot))
        return own or load_disturbances(self.disturbances or "default")

    def job(self, out: Path | None = None, database: SharedDatabase | None = None) -> Job:
        """The garment and the plan that folds it, of a study that may have begun in the folder `out`.

        Raises:
            InputError: An option is wrong.
        """
        from tatamu.folding.task import make_job

        if self.grasps not in ("integer", "continuous"):
            raise InputError(f"grasps: must be integer or continuous, given {self.grasps!r}")
        if self.hands not in (None, 1, 2):
            raise InputError(f"hands: must be 1 or 2, given {self.hands}")
        expected = self.expectation(out, database)
        return make_job(
            self.garment,
            size=None if self.size is None else parse_size(self.size),
            scale=self.scale,
            fold=self.fold,
            material=Path(self.material) if self.material else None,
            spacing=self.spacing,
            simulator=self.simulator,
            hands=self.hands,
            reach=_reach(self.robot),
            fingers=expected.disturbances.fingers if expected else None,
        )

    def learn(
        self, job: Job, out: Path, reporting: Reporting, executor: Executor | None, database: SharedDatabase | None
    ) -> Path:
        """Learn a job; returns the report. Errors are those of `learn_job`."""
        from tatamu.learning import learn_job

        return learn_job(
            job,
            out,
            trials=self.trials,
            seed=self.seed,
            sampler=self.sampler,
            grasps=self.grasps,  # type: ignore[arg-type]
            baselines=self.baselines,
            parallel=self.parallel,
            coarse=self.coarse,
            expectation=self._calibrated(job, out, database),
            executor=executor,
            database=database,
            reporting=reporting,
        )

    def _calibrated(self, job: Job, out: Path, database: SharedDatabase | None) -> Expectation | None:
        """The expectation, with a calibrated material's own uncertainties; one that began has them already."""
        from tatamu.disturbances import with_calibrated

        begun, held = self._held(out, database)
        if begun:
            return held
        given = self._given()
        if given is None or self.material is None:
            return given
        known = with_calibrated(given.disturbances, Path(self.material), job.garment.material)
        return replace(given, disturbances=known)


def share(quantile: str | None) -> float | Literal["mean"] | None:
    """A quantile, or the mean; None: nothing was asked."""
    if quantile is None or quantile == "mean":
        return quantile  # type: ignore[return-value]
    try:
        return float(quantile)
    except ValueError:
        raise InputError(f"quantile: must be a number or mean, given {quantile!r}") from None


def counted(trials: str) -> int | Literal["auto"]:
    """A number of trials, or auto."""
    if trials == "auto":
        return "auto"
    try:
        return int(trials)
    except ValueError:
        raise InputError(f"trials: must be a whole number or auto, given {trials!r}") from None


def _reach(robot: str | None) -> Reach | None:
    """The reach constraint of the robot of that name."""
    if robot is None:
        return None
    from tatamu.files import read_bytes
    from tatamu.folding.task import Reach
    from tatamu.robots import ReachConstraint, load
    from tatamu.robots.description import files_of

    loaded = load(robot)
    constraint = ReachConstraint(loaded)
    files = files_of(Path(robot)) if robot.endswith(".toml") else []
    description = read_bytes(files[0]) if files else b""
    return Reach(
        loaded.name, constraint, constraint.refusal, constraint.forget, description=description, files=tuple(files)
    )
