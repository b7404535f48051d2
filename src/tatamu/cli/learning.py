"""The options of `tatamu learn` as a record, which the tasks of a sweep have too, and what is learned from them."""

from __future__ import annotations

from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import ConfigDict, Field

from tatamu.cli.size import parse_size
from tatamu.errors import InputError
from tatamu.records import Record

if TYPE_CHECKING:
    from tatamu.folding.task import Job, Reach
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
    trials: Whole = 50
    seed: Whole = 0
    parallel: Whole | None = None
    robot: str | None = None
    baselines: YesNo = True

    def job(self) -> Job:
        """The garment and the plan that folds it.

        Raises:
            InputError: An option is wrong.
        """
        from tatamu.folding.task import make_job

        if self.grasps not in ("integer", "continuous"):
            raise InputError(f"grasps: must be integer or continuous, given {self.grasps!r}")
        if self.hands not in (None, 1, 2):
            raise InputError(f"hands: must be 1 or 2, given {self.hands}")
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
            executor=executor,
            database=database,
            reporting=reporting,
        )


def _reach(robot: str | None) -> Reach | None:
    """The reach constraint of the robot of that name."""
    if robot is None:
        return None
    from tatamu.folding.task import Reach
    from tatamu.robots import ReachConstraint, load
    from tatamu.robots.description import files_of

    loaded = load(robot)
    constraint = ReachConstraint(loaded)
    files = files_of(Path(robot)) if robot.endswith(".toml") else []
    description = files[0].read_bytes() if files else b""
    return Reach(loaded.name, constraint, constraint.refusal, description=description, files=tuple(files))
