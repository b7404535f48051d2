"""The options of learning and their defaults, which are defined only here.

The command line, sweep files, results, and the command on the result page are generated from these records or read
them. The module imports little, so that `tatamu --help` is quick.
"""

from __future__ import annotations

import warnings
from typing import Any, Literal, Self

from pydantic import ConfigDict, Field, StrictBool, StrictInt, ValidationError, model_validator

from tatamu.base.errors import InputError, check_range, describe
from tatamu.base.records import Record
from tatamu.evaluation.array import LEVEL, check_level
from tatamu.folding.aim import Aim

USUAL_PENDING = 2
"""Default number of pending trials, equal on all machines, because the results of a study depend on it. With more, new
trials know fewer results: they are chosen less well, and bad ones are stopped later."""
FORMER = {
    "quantile": "set the size of the disturbances with `level`",
    "coarse": "set the only mesh with `spacing`",
}
"""Options of version 0.2, and what took their place."""


class Options(Record):
    """Base of records of options. The descriptions of their fields are the help texts of the command line."""

    model_config = ConfigDict(allow_inf_nan=True)  # the checks report such numbers

    def __init__(self, **given: Any) -> None:
        """Make a record of options. Errors name the field."""
        try:
            super().__init__(**given)
        except ValidationError as error:
            raise InputError(describe(error, type(self))) from None

    def replace(self, **changes: Any) -> Self:
        """Return a copy with other values of some options."""
        given = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self)(**{**given, **changes})


class FoldOptions(Options):
    """Options of the garment and its fold, given by names and files."""

    garment: str = Field(
        description="Name of a garment (see `tatamu garments`), or a garment's file.",
        json_schema_extra={"metavar": "GARMENT"},
    )
    size: str | None = Field(
        None, description="Width x length in metres, such as 0.34x0.80.", json_schema_extra={"metavar": "WxL"}
    )
    scale: float | None = Field(
        None,
        description="Length of one unit in the garment's file [m], such as 0.001; default: as stated in the file.",
        json_schema_extra={"metavar": "M"},
    )
    fold: str = Field(
        "half",
        description="Fold plan: half, quarters (towel), shop (tshirt), leg or thirds (trousers), another plan "
        "that `tatamu plans` lists, your own file, or auto for the best plan.",
        json_schema_extra={"metavar": "NAME|FILE.toml"},
    )
    hands: StrictInt | None = Field(
        None, description="Number of hands, 1 or 2; default: as in the fold plan, usually 2."
    )
    material: str | None = Field(
        None,
        description="Material file, or a preset such as denim; default: the garment's own fabric.",
        json_schema_extra={"metavar": "FILE.toml"},
    )
    spacing: float | None = Field(
        None,
        description="Mesh spacing in metres; default: half the bending length of the cloth, or coarser for large "
        "garments.",
    )
    simulator: str = Field("native", description="Simulator: native, blender or mujoco.")
    robot: str | None = Field(
        None,
        description="Robot that must be able to carry out the fold: hironx, nextage, or another from "
        "`tatamu plan --help`.",
    )


class LearnOptions(Options):
    """Options of the search for a fold."""

    trials: StrictInt | Literal["auto"] = Field(
        50,
        description="Total number of trials of the study; auto: stop when a trial is expected to gain less than 0.1 %.",
        json_schema_extra={"metavar": "N|auto"},
    )
    seed: StrictInt = Field(0, description="Random seed of the search.")
    sampler: str = Field("gp", description="Method of the search: gp, tpe, cmaes or random.")
    grasps: Literal["integer", "continuous"] = Field(
        "integer",
        description="How the search treats the index of a grasp candidate: `integer`, or `continuous` (a real number "
        "that is rounded down).",
    )
    disturbances: Any = Field(
        None,
        description="Disturbances of hands, cloth and table that the fold must tolerate; with `none`, the search only "
        "minimises the objective C. Default: as in the study or the robot's .toml file, otherwise `default`.",
        json_schema_extra={"metavar": "default|none|FILE.toml"},
    )
    """As on the command line, or `Disturbances`; None for the default disturbances."""
    level: float = Field(LEVEL, description="Size of the disturbances during the search, in standard deviations.")
    aim: str | None = Field(
        None,
        description="Safety distances of the hands in metres, to allow for errors: height above the table, depth into "
        "the cloth, and distance from the ends of an edge; default: as the disturbances require.",
        json_schema_extra={"metavar": "none|HxIxE"},
    )
    parallel: StrictInt | None = Field(
        None,
        description=f"Number of trials that run at a time; default: {USUAL_PENDING}. With 1, each trial is "
        "proposed from all earlier results.",
    )
    baselines: StrictBool = Field(True, description="Also score three fixed trajectories, for comparison.")

    @model_validator(mode="after")
    def _check(self) -> Self:
        from tatamu.search.search import check_search

        check_search(self.sampler)
        if self.trials == "auto" and self.sampler != "gp":
            raise InputError(
                f"trials: auto needs the sampler gp, given {self.sampler}; give a number of trials, or the sampler gp"
            )
        if self.trials != "auto":
            check_range("trials", self.trials, 1, 10_000)
        check_range("seed", self.seed, 0, 2**32 - 1)
        if self.parallel is not None:
            check_range("parallel", self.parallel, 1, 16)  # with more, each is proposed from too few results
        check_level(self.level)
        if self.aim is not None:
            parse_aim(self.aim)
        return self

    @model_validator(mode="before")
    @classmethod
    def _drop_former(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        for name in FORMER.keys() & given.keys():
            if given[name] is not None:
                warnings.warn(f"{name}: no longer has an effect; {FORMER[name]}", FutureWarning, stacklevel=5)
        return {name: value for name, value in given.items() if name not in FORMER}


def parse_aim(text: str) -> Aim:
    """Return the aim that a text such as 0.003x0.003x0.006 or none states."""
    if text == "none":
        return Aim()
    try:
        height, into, from_end = (float(part) for part in text.split("x"))
        return Aim(height=height, into=into, from_end=from_end)
    except ValueError:
        raise InputError(
            f"aim: must be none or three lengths from 0 to 0.05 m, such as 0.003x0.003x0.006, given {text!r}"
        ) from None


class TaskRequest(LearnOptions, FoldOptions):
    """The options of `tatamu learn`, and of one task of a sweep."""

    @property
    def learning(self) -> LearnOptions:
        return LearnOptions(**{name: getattr(self, name) for name in LearnOptions.model_fields})

    def words(self) -> list[str]:
        """Return the words of the command line that give these options: the garment first, defaults omitted."""
        found = [self.garment]
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if name == "garment" or value == field.default:
                continue
            option = name.replace("_", "-")
            if isinstance(value, bool):
                found.append(f"--{option}" if value else f"--no-{option}")
            else:
                found += [f"--{option}", repr(value) if isinstance(value, float) else str(value)]
        return found
