"""What ruler, scale and board said, as `measurements.toml` holds it; docs/guide/calibration.md shows each reading.

    [garment]     name, size, mass                what it is, and its mass
    [elongation]  grasps, L1, L2                  paper, section IV-A
    [friction]    L_t, H_s                        paper, section IV-B
    [sag]         edge, free_length, sag          paper, section IV-C
    [loop]        height                          bending of limp cloth, and at the curvature of a fold
    [push]        length, pushed, moved           whether cloth that is pushed wrinkles or slides
    [errors]      length, mass, H_s               standard deviation of one reading

A reading is a number or a list of repeats. SI units: metres and kilograms.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from tatamu.calibration.quantity import Distances, Error, Length, Lengths, Masses
from tatamu.files import read_toml, validated
from tatamu.material import THICKNESS

HIGHEST_LOOP = 0.3
"""A fold higher than this [m] would be of a sheet of card."""


class Part(BaseModel):
    """Base of the tables: frozen, every key known, every number finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class GarmentReadings(Part):
    """Which garment, and its mass."""

    name: str
    """A garment's name or file, as `tatamu learn` takes it."""
    size: Annotated[tuple[Length, Length], BeforeValidator(lambda v: tuple(v) if isinstance(v, list) else v)] | None = (
        None
    )
    """Width and length [m]; None: the garment's own."""
    mass: Masses
    """Of the whole garment [kg]."""
    material: str | None = None
    """Preset or material file that gives what is not measured; None: the garment's own fabric."""
    thickness: Annotated[float, Field(ge=THICKNESS[0], le=THICKNESS[1])] | None = None
    """Of one layer [m], as `Material.thickness`; None: the material's."""


class Grasp(Part):
    """A straight grip on an edge of the garment."""

    edge: str
    """Name of the edge; `tatamu show GARMENT` draws them."""
    at: float = Field(0.5, ge=0.0, le=1.0)
    """Where along the edge the middle of the grip is, 0 and 1 being its ends."""
    width: Length | None = None
    """Width of the grip along the edge [m]; None: the whole edge, as a hanger or two rulers hold it."""


class ElongationReadings(Part):
    """Hanging and lying length (paper, section IV-A, Fig. 1)."""

    grasps: Annotated[list[Grasp], Field(min_length=1)]
    """By what it hangs."""
    L1: Lengths
    """From the grip straight down to the lowest end, hanging [m]."""
    L2: Lengths
    """The same two places, lying [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        hanging, lying = float(np.mean(self.L1)), float(np.mean(self.L2))
        if lying > hanging:
            raise ValueError(
                f"L2 ({lying:g} m, lying) is longer than L1 ({hanging:g} m, hanging), but cloth does not hang shorter "
                "than it lies; were they swapped, or was the cloth pulled when L2 was read?"
            )
        if hanging > 1.5 * lying:
            raise ValueError(
                f"L1 ({hanging:g} m) is more than half as long again as L2 ({lying:g} m): beyond what the simulators "
                "mean by cloth; was the same end read twice, in the same unit?"
            )
        return self


class FrictionReadings(Part):
    """The board, and how high its end is lifted when the cloth slides (paper, section IV-B)."""

    L_t: Lengths
    """Length of the board from the end that stays to the end that is lifted [m]."""
    H_s: Lengths
    """Height of the lifted end when the cloth starts to slide [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        board = float(np.mean(self.L_t))
        for height in self.H_s:
            if height >= board:
                raise ValueError(
                    f"H_s ({height:g} m) must be less than L_t ({board:g} m): the end of a board is not lifted "
                    "higher than the board is long"
                )
        if max(self.H_s) > 0.95 * board:
            raise ValueError(
                f"H_s ({max(self.H_s):g} m) of a board of {board:g} m is a slope over 70 degrees: the cloth is "
                "caught on the board, not held by friction"
            )
        return self


class SagReadings(Part):
    """How far the cloth in front of a straight grip hangs down (paper, section IV-C, Fig. 3)."""

    edge: str
    """Name of the edge beside which the cloth is held."""
    free_length: Lengths
    """From the front of the grip to the edge, along the cloth [m]."""
    sag: Lengths
    """From the grip vertically down to the lowest point, the edge [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        free = float(np.mean(self.free_length))
        for sag in self.sag:
            if sag >= free:
                raise ValueError(
                    f"sag ({sag:g} m) must be less than free_length ({free:g} m): the edge cannot hang "
                    "farther below the grip than there is cloth between them"
                )
        if free < 0.01:
            raise ValueError(f"free_length must be at least 0.01 m, given {free:g} m: a ruler cannot tell")
        return self


class LoopReadings(Part):
    """How high cloth stands where it is folded over itself."""

    height: Lengths
    """From the table to the top of the loop [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if max(self.height) > HIGHEST_LOOP:
            raise ValueError(
                f"height ({max(self.height):g} m) is more than a fold of cloth stands, {HIGHEST_LOOP:g} m: "
                "was it read in centimetres or millimetres?"
            )
        return self


class PushReadings(Part):
    """How far the far edge of cloth on a table moves when a ruler pushes the near one."""

    length: Lengths
    """Of the cloth ahead of the ruler, in the direction of the push [m]."""
    pushed: Lengths
    """How far the ruler was pushed [m]."""
    moved: Distances
    """How far the far edge moved [m]; 0 where it stayed."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        length, pushed = float(np.mean(self.length)), float(np.mean(self.pushed))
        for moved in self.moved:
            if moved > pushed:
                raise ValueError(
                    f"moved ({moved:g} m) must be at most pushed ({pushed:g} m): the far edge does not go farther than "
                    "the ruler; was the cloth pulled?"
                )
        if pushed > 0.3 * length:
            raise ValueError(
                f"pushed ({pushed:g} m) must be at most 0.3 of length ({length:g} m): cloth heaps up before the ruler"
            )
        return self


class Errors(Part):
    """Standard deviation of one reading, all causes together: the ruler's marks, the eye, the cloth's unrest."""

    length: Error = 0.001
    """Of every length but H_s [m]."""
    mass: Error = 0.001
    """[kg]"""
    H_s: Error = 0.005
    """[m]"""


class Measurements(Part):
    """All readings of one garment; a test that was not made is left out."""

    version: Literal[1] = 1
    garment: GarmentReadings
    elongation: ElongationReadings | None = None
    friction: FrictionReadings | None = None
    sag: SagReadings | None = None
    loop: LoopReadings | None = None
    push: PushReadings | None = None
    errors: Errors = Field(default_factory=Errors)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.elongation is None and self.friction is None and self.sag is None and self.loop is None:
            raise ValueError("must hold at least one of the tables [elongation], [friction], [sag], [loop]; given none")
        if self.push is not None and (self.elongation is None or self.friction is None):
            raise ValueError("push: needs [elongation] and [friction] as well, as what resists a push depends on both")
        return self


def load_measurements(path: Path) -> Measurements:
    """Read and check measurements.

    Raises:
        InputError: The file cannot be read, a field is unknown or a reading impossible; the message says which.
    """
    return validated(Measurements, read_toml(path), path)


def uncertainty(readings: tuple[float, ...], error: float) -> float:
    """Standard uncertainty of the mean: the stated error, or the scatter of repeats if larger, over sqrt(n)."""
    scatter = float(np.std(readings, ddof=1)) if len(readings) > 2 else 0.0
    return max(error, scatter) / float(np.sqrt(len(readings)))
