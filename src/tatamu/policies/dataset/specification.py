"""The specification of a dataset. docs/reference/dataset-file.md explains every field."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self, get_args

from pydantic import Field, StrictInt, model_validator

from tatamu.base.files import read_toml, validated
from tatamu.base.records import Record
from tatamu.policies.dataset.distribution import Distribution, Names, highest
from tatamu.policies.envs.cameras import Camera
from tatamu.simulation.material import Number

MAX_EPISODES = 1_000_000
Format = Literal["lerobot", "zarr"]
FORMATS: tuple[Format, ...] = get_args(Format)


class GarmentDraw(Record):
    """The garment, which is drawn at random for each fold."""

    name: Names = "towel"
    width: Distribution | None = None
    """Width of the garment [m]; None for the garment's own."""
    length: Distribution | None = None
    """Length of the garment [m]; None for the garment's own."""
    material: Names | None = None
    spacing: Annotated[Number, Field(gt=0.0)] | None = None
    """Edge length of the mesh [m]; None for the garment's own."""
    scale: Annotated[Number, Field(gt=0.0)] | None = None
    """Metres per unit of the garment's file; None if the file contains its unit."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.width is None) != (self.length is None):
            given, other = ("length", "width") if self.width is None else ("width", "length")
            raise ValueError(f"{other} must be given if {given} is given")
        return self

    @property
    def largest(self) -> tuple[float, float] | None:
        """Largest width and length that may be drawn [m]; None for the garment's own."""
        if self.width is None or self.length is None:
            return None
        return highest(self.width), highest(self.length)


class FoldDraw(Record):
    """The fold, which is drawn for each group of episodes."""

    source: Literal["drawn", "learned", "sweep"] = "drawn"
    plan: Names = "half"
    """Name or file of a plan, whose first step is folded; only for drawn folds."""
    hands: Literal[1, 2] | None = None
    """Number of hands; None for that of the plan; only for drawn folds."""
    spread: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.0
    """Largest deviation of each parameter from the learned fold or the arched curve, as a fraction of its range."""
    runs: Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)] | None = None
    """Folders of learned folds, for "learned"."""
    sweep: Annotated[str, Field(min_length=1)] | None = None
    """Folder of a sweep, for "sweep"."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for source, name in (("learned", "runs"), ("sweep", "sweep")):
            given = getattr(self, name)
            if self.source == source and given is None:
                raise ValueError(f"{name} must be given if source is {source!r}")
            if self.source != source and given is not None:
                raise ValueError(
                    f"{name} must be left out if source is {self.source!r}; give source = {source!r} to use {name}"
                )
        return self


class RobotDraw(Record):
    """The robot whose arms fold."""

    name: Annotated[str, Field(min_length=1)]
    place: Annotated[list[Number], Field(min_length=3, max_length=3)] | None = None
    """x, y [m] and yaw [rad] of the fold's frame in the robot's base; None to search."""
    table_height: Number | None = None
    """Height of the table top in the robot's base [m]; None to search."""


class RecordOptions(Record):
    """What is recorded."""

    fps: Annotated[StrictInt, Field(ge=5, le=60)] = 10
    """Frames per second [1/s]."""
    cameras: list[Camera] = Field(default_factory=lambda: list[Camera](("top", "front")))
    pixels: Annotated[StrictInt, Field(ge=64, le=512, multiple_of=2)] = 96
    """Height and width of pictures and masks [pixels]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(set(self.cameras)) < len(self.cameras):
            raise ValueError("cameras must not contain the same name twice")
        return self


class OutcomeOptions(Record):
    """Tests of each outcome, in addition to its score."""

    worlds: Annotated[StrictInt, Field(ge=0, le=10_000)] = 0
    """Number of scenarios that are simulated with each fold, besides the episodes."""
    simulator: Literal["mujoco", "blender"] | None = None
    """A second simulator, in which the hands make the same motion."""


class DatasetSpecification(Record):
    """The contents of the file that specifies a dataset."""

    version: Literal[1] = 1
    episodes: Annotated[StrictInt, Field(ge=1, le=MAX_EPISODES)]
    seed: Annotated[StrictInt, Field(ge=0, lt=2**32)] = 0
    formats: Annotated[list[Format], Field(min_length=1)] = Field(default_factory=lambda: list[Format](FORMATS))
    disturbances: str = "default"
    """`default`, `none`, or a file."""
    per_fold: Annotated[StrictInt, Field(ge=1, le=10_000)] = 1
    """Number of episodes with the same fold."""
    garment: GarmentDraw | None = None
    """Only for drawn folds; None for the default towel."""
    fold: FoldDraw = FoldDraw()
    robot: RobotDraw | None = None
    """None for floating hands."""
    record: RecordOptions = RecordOptions()
    outcome: OutcomeOptions = OutcomeOptions()

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(set(self.formats)) < len(self.formats):
            raise ValueError("formats must not contain the same name twice")
        if self.fold.source != "drawn":
            usual = FoldDraw.model_fields
            drawn = [name for name in ("plan", "hands") if getattr(self.fold, name) != usual[name].default]
            if self.garment is not None or drawn:
                given = "garment" if self.garment is not None else f"fold.{drawn[0]}"
                raise ValueError(f"{given} must be left out for learned folds, because each learned fold has its own")
        if self.disturbances == "none" and self.outcome.worlds:
            raise ValueError(f"outcome.worlds must be 0 if disturbances is 'none', given {self.outcome.worlds}")
        return self

    @property
    def drawn_garment(self) -> GarmentDraw:
        """The garment of drawn folds."""
        return self.garment or GarmentDraw()

    @property
    def cameras(self) -> list[Camera]:
        """Cameras that are recorded."""
        return self.record.cameras if "lerobot" in self.formats else []


def read_specification(path: Path) -> DatasetSpecification:
    """Read the file that specifies a dataset.

    Raises:
        InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
    """
    return validated(DatasetSpecification, read_toml(path), path)
