"""The specification of a dataset: the folds, the recorded data, and the tests of the outcome.

docs/reference/dataset-file.md explains every field.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self, get_args

from pydantic import Field, StrictInt, model_validator

from tatamu.base.files import read_toml, validated
from tatamu.base.records import Record
from tatamu.policies.dataset.distribution import Distribution, Names, highest
from tatamu.policies.envs.cameras import Camera
from tatamu.simulation.material import Number

MOST_EPISODES = 1_000_000
"""Largest number of episodes in a dataset."""
Format = Literal["lerobot", "zarr"]
FORMATS: tuple[Format, ...] = get_args(Format)
"""Names of the formats in which a dataset can be written."""


class GarmentDraw(Record):
    """The garment, which is drawn at random for each fold."""

    name: Names = "towel"
    """Name or file of a garment."""
    width: Distribution | None = None
    """Width of the garment [m]; None for the garment's own width."""
    length: Distribution | None = None
    """Length of the garment [m]; None for the garment's own length."""
    material: Names | None = None
    """Name or file of a material; None for the garment's own material."""
    spacing: Annotated[Number, Field(gt=0.0)] | None = None
    """Distance between vertices of the mesh [m]; None for the garment's own spacing."""
    scale: Annotated[Number, Field(gt=0.0)] | None = None
    """Metres per unit of the garment's file; None if the file contains its unit."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name, other in (("width", "length"), ("length", "width")):
            given = getattr(self, name)
            if given is not None and getattr(self, other) is None:
                raise ValueError(f"{other} must be given with {name}")
        return self

    @property
    def largest(self) -> tuple[float, float] | None:
        """The largest width and length that may be drawn [m]; None for the garment's own size."""
        if self.width is None or self.length is None:
            return None
        return highest(self.width), highest(self.length)


class FoldDraw(Record):
    """The fold, which is drawn at random for each episode or group of episodes."""

    source: Literal["drawn", "learned", "sweep"] = "drawn"
    plan: Names = "half"
    """Name or file of a fold plan, whose first step is folded. Used only for randomly drawn folds."""
    hands: Literal[1, 2] | None = None
    """Number of hands that fold; None for the number in the fold plan. Used only for randomly drawn folds."""
    spread: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.0
    """Largest difference of each curve parameter from the middle curve, as a fraction of the search space.

    The hands' curve is chosen at random near a middle curve. The middle curve is the learned fold's curve. Without a
    learned fold, it is the default curve, an arch.
    """
    runs: Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)] | None = None
    """Folders with learned folds, written by `tatamu learn`; None if `source` is not "learned"."""
    sweep: Annotated[str, Field(min_length=1)] | None = None
    """Folder of a sweep, written by `tatamu sweep`; None if `source` is not "sweep"."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for source, name in (("learned", "runs"), ("sweep", "sweep")):
            given = getattr(self, name)
            if self.source == source and given is None:
                raise ValueError(f"{name} must be given with source = {source!r}")
            if self.source != source and given is not None:
                raise ValueError(f"{name} is for source = {source!r}, given {self.source!r}")
        return self


class RobotDraw(Record):
    """The robot whose arms fold. If the file gives no place for the fold, the best place is searched for."""

    name: Annotated[str, Field(min_length=1)]
    """Name of a robot, or a .toml file that describes a robot."""
    place: Annotated[list[Number], Field(min_length=3, max_length=3)] | None = None
    """x, y [m] and yaw [rad] of the fold's frame in the robot's base; None to search for them."""
    table_height: Number | None = None
    """Height of the table top in the robot's base [m]; None to search for it."""


class RecordOptions(Record):
    """The observations that are recorded, and their rate."""

    fps: Annotated[StrictInt, Field(ge=5, le=60)] = 10
    """Frames per second [1/s]."""
    cameras: list[Camera] = Field(default_factory=lambda: list[Camera](("top", "front")))
    """Cameras whose pictures are stored as videos."""
    pixels: Annotated[StrictInt, Field(ge=64, le=512, multiple_of=2)] = 96
    """Height and width of pictures and masks [pixels]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(set(self.cameras)) < len(self.cameras):
            raise ValueError("cameras must differ")
        return self


class OutcomeOptions(Record):
    """Tests of each outcome, in addition to its score."""

    worlds: Annotated[StrictInt, Field(ge=0, le=10_000)] = 0
    """Number of additional disturbed simulations of each fold.

    The dataset contains the success rate of the fold in these simulations.
    """
    simulator: Literal["mujoco", "blender"] | None = None
    """A second simulator that repeats the hands' motion of each episode; None for no second simulator."""


class DatasetSpecification(Record):
    """The contents of the file that specifies a dataset."""

    version: Literal[1] = 1
    episodes: Annotated[StrictInt, Field(ge=1, le=MOST_EPISODES)]
    seed: Annotated[StrictInt, Field(ge=0, lt=2**32)] = 0
    formats: Annotated[list[Format], Field(min_length=1)] = Field(default_factory=lambda: list[Format](FORMATS))
    disturbances: str = "default"
    """The disturbances: `default`, `none`, or a file. They are drawn at random for every episode."""
    per_fold: Annotated[StrictInt, Field(ge=1, le=10_000)] = 1
    """Number of episodes with the same fold. The disturbances are drawn again for each of them."""
    garment: GarmentDraw | None = None
    """Garment of randomly drawn folds; None for the towel of `tatamu learn towel`."""
    fold: FoldDraw = FoldDraw()
    robot: RobotDraw | None = None
    """The robot whose arms fold; None for floating hands."""
    record: RecordOptions = RecordOptions()
    outcome: OutcomeOptions = OutcomeOptions()

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(set(self.formats)) < len(self.formats):
            raise ValueError("formats must differ")
        if self.fold.source != "drawn":
            usual = FoldDraw.model_fields
            drawn = [name for name in ("plan", "hands") if getattr(self.fold, name) != usual[name].default]
            if self.garment is not None or drawn:
                given = "garment" if self.garment is not None else f"fold.{drawn[0]}"
                raise ValueError(f"{given} is for drawn folds; learned ones have theirs")
        if self.disturbances == "none" and self.outcome.worlds:
            raise ValueError("outcome.worlds needs disturbances, given none")
        return self

    @property
    def drawn_garment(self) -> GarmentDraw:
        """The garment of randomly drawn folds."""
        return self.garment or GarmentDraw()

    @property
    def cameras(self) -> list[Camera]:
        """Cameras whose pictures are recorded."""
        return self.record.cameras if "lerobot" in self.formats else []


def read_specification(path: Path) -> DatasetSpecification:
    """Read the file that specifies a dataset.

    Raises:
        InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
    """
    return validated(DatasetSpecification, read_toml(path), path)
