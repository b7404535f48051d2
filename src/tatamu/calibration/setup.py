"""The simulated copy of what was measured: the same garment, the same tests."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.calibration.elongation import Elongation, named_edge
from tatamu.calibration.friction import Slope
from tatamu.calibration.loop import Loop
from tatamu.calibration.measurements import Measurements
from tatamu.calibration.push import Push
from tatamu.calibration.sag import Sag
from tatamu.errors import InputError
from tatamu.garments import GARMENTS, Garment, make_garment
from tatamu.material import Material, load_material
from tatamu.topology import areas

SPACING = 0.02
"""Mesh spacing of the hanging garment [m]."""
OTHER_GARMENT = 0.25
"""An L2 that is off the garment's own length by more than this part belongs to another garment, or to other grasps."""
SHORTEST_EDGE = 1.5
"""The edge of a sag test is at least this many free lengths long, or its ends would hang differently."""


@dataclass(frozen=True)
class Setup:
    """Tests that were made, on the garment that was measured."""

    garment: Garment
    base: Material
    """What is not measured."""
    elongation: Elongation | None
    slope: Slope | None
    sag: Sag | None
    loop: Loop | None
    push: Push | None = None

    @property
    def area(self) -> float:
        """Of all layers together [m^2]."""
        return float(areas(self.garment.cloth().rest, self.garment.faces).sum())


def setup_of(measurements: Measurements, spacing: float | None = None) -> Setup:
    """The tests of some measurements.

    Args:
        measurements: What was measured.
        spacing: Mesh spacing of garment and strip [m]; None: fine enough that it does not matter.

    Raises:
        InputError: The garment, its material or an edge does not exist.
    """
    given = measurements.garment
    material = load_material(Path(given.material)) if given.material else None
    if material is not None and given.thickness:
        material = material.model_copy(update={"thickness": given.thickness})
    garment = make_garment(given.name, given.size, material, spacing or (SPACING if given.name in GARMENTS else None))
    thick = {"thickness": given.thickness} if given.thickness else {}
    base = garment.material.model_copy(update={**thick, "blender": None})
    hung, tilted, held = measurements.elongation, measurements.friction, measurements.sag
    elongation = Elongation(garment, tuple(hung.grasps)) if hung else None
    if hung is not None and elongation is not None:
        elongation.held  # noqa: B018  names an unknown edge now, not after the first simulation
        _check_length(elongation, float(np.mean(hung.L2)))
    slope = Slope(float(np.arcsin(np.mean(tilted.H_s) / np.mean(tilted.L_t)))) if tilted else None
    sag = Sag(float(np.mean(held.free_length)), spacing) if held else None
    if held is not None and sag is not None:
        _check_edge(garment, held.edge, sag.free_length)
    loop = None
    if measurements.loop is not None:
        loop = Loop(float(np.mean(measurements.loop.height)), base.thickness, spacing)
        _check_height(loop)
    push = None
    if measurements.push is not None:
        push = Push(float(np.mean(measurements.push.length)), float(np.mean(measurements.push.pushed)), spacing)
    return Setup(garment, base, elongation, slope, sag, loop, push)


def _check_length(elongation: Elongation, lying: float) -> None:
    if abs(lying / elongation.length - 1.0) > OTHER_GARMENT:
        raise InputError(
            f"elongation: L2 ({lying:g} m) is not of this garment, which lies {elongation.length:.2f} m long from the "
            "grip to the end farthest from it: is its size right, and are the grasps those by which it hung?"
        )


def _check_edge(garment: Garment, name: str, free_length: float) -> None:
    path = garment.vertices[named_edge(garment, name), :2]
    along = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    if along < SHORTEST_EDGE * free_length:
        raise InputError(
            f"sag: edge {name} is {along:.2f} m long; with a free length of {free_length:g} m its ends hang "
            f"differently from its middle: choose a free length up to {along / SHORTEST_EDGE:.2f} m, or a longer edge"
        )


def _check_height(loop: Loop) -> None:
    if loop.height <= 2.0 * loop.thickness:
        raise InputError(
            f"loop: height ({loop.height:g} m) must be more than two layers, {2.0 * loop.thickness:g} m: was the loop "
            "pressed flat, or is the garment's thickness (of one layer) less?"
        )
