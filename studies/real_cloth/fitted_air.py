"""Drag and added mass of air, over the density of the cloth, fitted to swings; laws with one number or several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from studies.real_cloth.pendulum import AirLaw
from studies.real_cloth.recording import Recording
from studies.real_cloth.sheet import SIDE
from tatamu.plate_in_air import rectangle_added_mass, steady_drag, turning_drag

START = (0.5, 1.0, 6.0)
"""Added mass, linear and quadratic drag with which a fit starts, divided by the density."""
START_TURNING = (0.5, 0.3, 4.0)
"""Added mass, linear drag and turning drag with which a fit starts, divided by the density."""
START_SIZE = (0.3,)
"""Density [kg/m^2] with which a fit of the density alone starts."""
STEP = 0.1
"""Step of the differences in a fit, as a fraction of the starting value."""
EVALUATIONS = 3
"""Largest number of evaluations of the residuals' derivatives in a fit."""
RECTANGLE = rectangle_added_mass(SIDE, SIDE)
"""Air that a plate of the cloth's size carries [kg/m^2]."""
TYPICAL = 0.01
"""Residuals beyond this [m] count less than their squares, because the camera has outliers."""


def fit(
    predict: Callable[[AirLaw], list[np.ndarray]],
    recordings: Sequence[Recording],
    law: Callable[[np.ndarray], AirLaw],
    start: Sequence[float],
) -> AirLaw:
    """Air by least squares on the swing, outliers counting less.

    Args:
        predict: Swings of the recordings in that air.
        recordings: The measured recordings.
        law: Returns the air for some numbers.
        start: The numbers with which the fit starts.
    """
    wanted = np.concatenate([recording.swing for recording in recordings])
    good = np.isfinite(wanted)

    def air(parts: np.ndarray) -> AirLaw:
        # rounded, so that a repeated fit asks for the very scenes that are kept
        return law(np.array([float(f"{value:.4g}") for value in parts * start]))

    def residuals(parts: np.ndarray) -> np.ndarray:
        return (np.concatenate(predict(air(parts))) - wanted)[good]

    found = least_squares(
        residuals,
        np.ones(len(start)),
        jac=partial(_differences, residuals),
        bounds=(0.0, np.inf),
        loss="soft_l1",
        f_scale=TYPICAL,
        max_nfev=EVALUATIONS,
    )
    return air(found.x)


def steady(numbers: np.ndarray) -> AirLaw:
    """Added mass, linear and quadratic drag."""
    return AirLaw(*(float(value) for value in numbers))


def linear(numbers: np.ndarray) -> AirLaw:
    """Linear drag alone."""
    return AirLaw(linear=float(numbers[0]))


def of_size(numbers: np.ndarray) -> AirLaw:
    """Return the air of a rigid plate of the cloth's size, divided by a density [kg/m^2], the only number."""
    density = float(numbers[0])
    return AirLaw(RECTANGLE / density, 0.0, steady_drag() / density, turning_drag(SIDE) / density)


def turning(numbers: np.ndarray) -> AirLaw:
    """Return air with added mass, linear drag and turning drag."""
    added_mass, drag, around = (float(value) for value in numbers)
    return AirLaw(added_mass, drag, 0.0, around)


def said(air: AirLaw) -> str:
    """Return the nonzero numbers as text."""
    parts = {
        f"added mass {air.added_mass:.2f} ρ": air.added_mass,
        f"linear drag {air.linear:.2f} ρ/s": air.linear,
        f"quadratic drag {air.quadratic:.1f} ρ/m": air.quadratic,
        f"turning drag {air.turning:.2f} ρ/m^(2/3)": air.turning,
    }
    return ", ".join(text for text, value in parts.items() if value > 0.0)


def said_by_size(air: AirLaw) -> str:
    """Return as text the density for which the air of a plate of that size is this one, and its numbers."""
    return f"density {RECTANGLE / air.added_mass:.2f} kg/m²; air by size: {said(air)}"


def _differences(residuals: Callable[[np.ndarray], np.ndarray], numbers: np.ndarray) -> np.ndarray:
    here = residuals(numbers)
    return np.column_stack([(residuals(numbers + STEP * unit) - here) / STEP for unit in np.eye(len(numbers))])
