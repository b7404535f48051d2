"""Fits the effects of air on a cloth, which are drag and added mass, to swings of the cloth.

The areal density of the cloth is unknown, so only the effects divided by this density can be found. There are several
laws of air (formulas for the added mass and the drag of air), with one or more fitted numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from benchmarks.plate_in_air import rectangle_added_mass, steady_drag, turning_drag
from scipy.optimize import least_squares

from studies.real_cloth.pendulum import AirLaw
from studies.real_cloth.recording import Recording
from studies.real_cloth.sheet import SIDE

START = (0.5, 1.0, 6.0)
"""Added mass, linear and quadratic drag with which a fit starts, divided by the areal density."""
START_TURNING = (0.5, 0.3, 4.0)
"""Added mass, linear and turning drag with which a fit starts, divided by the areal density."""
START_SIZE = (0.3,)
"""Areal density of the cloth with which a fit starts [kg/m^2]. The density is the only number that is fitted."""
STEP = 0.1
"""Step for numerical derivatives in the fit of the effects of air, as a fraction of a number's starting value."""
EVALUATIONS = 3
"""Largest number of evaluations of the residuals' derivatives in the fit of the effects of air."""
RECTANGLE = rectangle_added_mass(SIDE, SIDE)
"""Added mass of a plate of the cloth's size: the mass of air that moves with it, per area [kg/m^2]."""
TYPICAL = 0.01
"""Maximum residual that counts with its square [m]. Larger ones may be outliers of the camera."""


def fit(
    predict: Callable[[AirLaw], list[np.ndarray]],
    recordings: Sequence[Recording],
    law: Callable[[np.ndarray], AirLaw],
    start: Sequence[float],
) -> AirLaw:
    """Fit numbers, from which `law` makes coefficients of air, to the swings of recordings by robust least squares.

    `predict` returns the swings of all recordings for given coefficients.
    """
    wanted = np.concatenate([recording.swing for recording in recordings])
    good = np.isfinite(wanted)

    def air(parts: np.ndarray) -> AirLaw:
        # rounded, so a repeated fit simulates exactly the same scenes, whose readings are kept
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
    """Return coefficients of air from three `numbers`: added mass, linear drag and quadratic drag."""
    return AirLaw(*(float(value) for value in numbers))


def linear(numbers: np.ndarray) -> AirLaw:
    """Return coefficients of air with linear drag only; `numbers` has this drag as its only entry."""
    return AirLaw(linear=float(numbers[0]))


def of_size(numbers: np.ndarray) -> AirLaw:
    """Return the coefficients on a rigid plate of the cloth's size, whose areal density is the only number."""
    density = float(numbers[0])
    return AirLaw(RECTANGLE / density, 0.0, steady_drag() / density, turning_drag(SIDE) / density)


def turning(numbers: np.ndarray) -> AirLaw:
    """Return coefficients of air from three `numbers`: added mass, linear drag and turning drag."""
    added_mass, drag, around = (float(value) for value in numbers)
    return AirLaw(added_mass, drag, 0.0, around)


def said(air: AirLaw) -> str:
    """Return those coefficients of air (added mass and drag) that are not zero, as text."""
    parts = {
        f"added mass {air.added_mass:.2f} ρ": air.added_mass,
        f"linear drag {air.linear:.2f} ρ/s": air.linear,
        f"quadratic drag {air.quadratic:.1f} ρ/m": air.quadratic,
        f"turning drag {air.turning:.2f} ρ/m^(2/3)": air.turning,
    }
    return ", ".join(text for text, value in parts.items() if value > 0.0)


def said_by_size(air: AirLaw) -> str:
    """Return the coefficients of air from `of_size` as text, with the areal density of the cloth."""
    return f"density {RECTANGLE / air.added_mass:.2f} kg/m²; air by size: {said(air)}"


def _differences(residuals: Callable[[np.ndarray], np.ndarray], numbers: np.ndarray) -> np.ndarray:
    here = residuals(numbers)
    return np.column_stack([(residuals(numbers + STEP * unit) - here) / STEP for unit in np.eye(len(numbers))])
