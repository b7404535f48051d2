"""Advice on the measurements: which readings are insufficient, which would suffice, and which should be repeated."""

from __future__ import annotations

import numpy as np

from tatamu.calibration.estimate import Fit
from tatamu.calibration.measurements import TESTS
from tatamu.calibration.parameters import KNOWN, PLACE, SYMBOLS
from tatamu.calibration.result import Calibration
from tatamu.calibration.test import millimetres, texts
from tatamu.show.quantity import filed, shown, usual

MORE = 3
"""Number of additional repeats of a reading that the user is advised to make."""


def _named(**described: str) -> list[str]:
    """Return the names of the calibration tests whose class attributes have the given values."""
    return [name for name, test in TESTS.items() if all(getattr(test, key) == said for key, said in described.items())]


NAMES = {
    "mass": "the mass",
    "width": "the width of the garment",
    "length": "the length of the garment",
    "chance": "where folds of the simulated cloth begin",
    "search": f"the last step of the search for {' and '.join(_named(samples='speed'))}",
    "disagreement": f"{' and '.join(_named(parameter='bending_rigidity'))}, which disagree",
    **{reading: words for test in TESTS for reading, words in texts(test)["words"].items()},
}
"""Names in words of everything that contributes to the uncertainty: readings, and causes such as the search."""


def advice_on(calibration: Calibration) -> list[str]:
    """Return the advice on a calibration as sentences, the most important sentence first."""
    advice = [text for fit in calibration.fits for text in _of_fit(calibration, fit)]
    advice += _disagreement(calibration)
    advice += [text for fit in calibration.fits for text in calibration.setup.tests[fit.test].remark(calibration, fit)]
    advice += _unused(calibration) + _restless(calibration)
    repeated = best_repeat(calibration)
    if repeated is not None:
        name, gains = repeated
        gained = ", ".join(
            f"{SYMBOLS[parameter]} from {100 * before:.1f} to {100 * after:.1f} %" for parameter, before, after in gains
        )
        advice.append(f"Most would be gained by {MORE} more readings of {NAMES[name]}: {gained}.")
    return advice


def _of_fit(calibration: Calibration, fit: Fit) -> list[str]:
    test = calibration.setup.tests[fit.test]
    if fit.alone is not None and calibration.bounding(fit.parameter) is not fit:
        return _left_out(calibration, fit) if fit.bound else []
    value = getattr(calibration.material, fit.parameter)
    kept = fit.alone is not None and fit.alone != value  # the assumed value satisfies the bound of the test
    said = []
    if not kept and abs(fit.simulated - fit.aim) > fit.uncertainty:
        said.append(
            f"{fit.test}: {calibration.simulator} reaches only {_shown(fit, fit.simulated)}, but the reading asks for "
            f"{_shown(fit, fit.aim)}, so {SYMBOLS[fit.parameter]} is {fit.bound} "
            f"{f'{value:.3g} {filed(KNOWN[fit.parameter].unit)}'.strip()}. Is the reading right?"
        )
        if fit.aim == fit.measured:  # the simulator cannot reproduce the reading
            return said
    return said + test.advice(calibration, fit)


def _shown(fit: Fit, value: float) -> str:
    """Return a value as text, in the unit with which pages show the reading of this fit."""
    return millimetres(value) if fit.unit == "m" else shown(value, usual(fit.unit), ".3g")


def _left_out(calibration: Calibration, fit: Fit) -> list[str]:
    """Return a note on a test whose reading the simulator cannot reproduce, while another test can."""
    others = [each.test for each in calibration.fits if each.parameter == fit.parameter and each is not fit]
    symbol = SYMBOLS[fit.parameter]
    return [
        f"{fit.test}: no value of {symbol} makes {calibration.simulator} reach {millimetres(fit.aim)}, so {symbol} is "
        f"taken from the {others[0]} alone, which gives {millimetres(fit.simulated)}. Is the reading right?"
    ]


def _disagreement(calibration: Calibration) -> list[str]:
    """Return a note if no single bending rigidity fits all bending tests."""
    if "disagreement" not in calibration.contributions:
        return []
    bending = [fit for fit in calibration.fits if fit.parameter == "bending_rigidity"]
    alone = {fit.test: 1e6 * fit.alone for fit in bending if fit.alone is not None}
    says = " and the ".join(f"{test} alone says {value:.3g}" for test, value in alone.items())
    taken = 1e6 * calibration.material.bending_rigidity
    return [
        f"bending: the {says} µN m, because this cloth does not bend in proportion to its curvature. The weighted mean "
        f"{taken:.3g} is used, and its uncertainty covers the difference."
    ]


def _unused(calibration: Calibration) -> list[str]:
    """Return notes on tests that were made but are not used, each with the reason."""
    setup = calibration.setup
    reasons = {name: setup.unused(test, calibration.simulator) for name, test in setup.tests.items()}
    return [f"{name}: not used, {why}." for name, why in reasons.items() if why]


def _restless(calibration: Calibration) -> list[str]:
    """Return a note if the simulated cloth still moves by about the error of a ruler when its reading is taken."""
    errors = [fit.uncertainty for fit in calibration.fits if fit.unit == "m"]
    if not errors or calibration.unsettled < 0.5 * min(errors):
        return []
    return [
        f"the cloth in {calibration.simulator} does not come to rest: a reading still changed by "
        f"{millimetres(calibration.unsettled)} in the last quarter of its test, so its mean is used."
    ]


def best_repeat(calibration: Calibration) -> tuple[str, list[tuple[str, float, float]]] | None:
    """Return the reading whose `MORE` repeats lower the sum of the relative variances the most, or None.

    With it come the relative uncertainties of parameters before and after the repeats.
    """
    rows = [PLACE[name] for name in calibration.known]
    variance = np.diag(calibration.covariance)[rows]
    if not len(rows) or not variance.min() > 0.0:
        return None
    lowered = {
        name: variance - calibration.contributions[name][rows] ** 2 * MORE / (reading.repeats + MORE)
        for name, reading in calibration.readings.items()
    }
    best = min(lowered, key=lambda name: float(lowered[name].sum()))
    gains = [
        (calibration.known[k], float(np.sqrt(variance[k])), float(np.sqrt(lowered[best][k])))
        for k in range(len(rows))
        if lowered[best][k] < 0.95 * variance[k]
    ]
    return (best, gains) if gains else None
