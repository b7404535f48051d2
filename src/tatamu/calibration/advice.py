"""What to tell the person who measured: which readings cannot tell, what would, and what to repeat."""

from __future__ import annotations

import numpy as np

from tatamu.calibration.loop import HEIGHT, LIFT
from tatamu.calibration.result import PARAMETERS, SYMBOLS, UNITS, Calibration, Fit
from tatamu.heavy_strip.cantilever import tip

POOR = 0.25
"""A relative standard uncertainty above this is said to tell hardly anything."""
BEST = 1.8
"""Free length over bending length at which the edge hangs down about half of it."""
SHORTEST = 0.025
"""Least free length that a ruler of 1 mm and two other rulers as a grip can do [m]."""
MORE = 3
"""Repeats that the advice counts with."""
NAMES = {
    "mass": "the mass",
    "width": "the width of the garment",
    "length": "the length of the garment",
    "L1": "L1, the hanging length",
    "L2": "L2, the lying length",
    "L_t": "L_t, the board",
    "H_s": "H_s, the lifted end",
    "free_length": "the free length",
    "sag": "the sag",
    "height": "the height of the loop",
    "push_length": "the length of the cloth ahead of the ruler",
    "pushed": "how far the ruler was pushed",
    "moved": "how far the far edge moved",
    "search": "the last step of the search for friction",
    "disagreement": "sag and loop, which disagree",
}


def advice_on(calibration: Calibration) -> list[str]:
    """Sentences, the most important first."""
    advice = [text for fit in calibration.fits for text in _of_fit(calibration, fit)]
    advice += _disagreement(calibration) + _substitution(calibration) + _unused(calibration) + _restless(calibration)
    repeated = best_repeat(calibration)
    if repeated is not None:
        name, gains = repeated
        told = ", ".join(
            f"{SYMBOLS[parameter]} from {100 * before:.1f} to {100 * after:.1f} %" for parameter, before, after in gains
        )
        advice.append(f"To gain most, read {NAMES[name]} {MORE} more times: {told}.")
    return advice


def _of_fit(calibration: Calibration, fit: Fit) -> list[str]:
    if fit.alone is not None and calibration.bounding(fit.parameter) is not fit:
        return _left_out(calibration, fit) if fit.bound else []
    if fit.test == "push" and fit.alone is not None:
        return _push(calibration, fit)
    texts = []
    if abs(fit.simulated - fit.aim) > fit.uncertainty:
        value = getattr(calibration.material, fit.parameter)
        texts.append(
            f"{fit.test}: {calibration.simulator} comes to {_mm(fit.simulated)}, not to the {_mm(fit.aim)} asked for: "
            f"its nearest is taken, {SYMBOLS[fit.parameter]} is {fit.bound} {value:.3g} {UNITS[fit.parameter]}. Is the "
            "reading right?"
        )
        if fit.aim == fit.measured:  # the reading could tell, the simulator could not follow
            return texts
    if fit.test == "elongation":
        texts += _elongation(calibration, fit)
    elif fit.test == "sag":
        texts += _sag(calibration, fit)
    elif fit.test == "loop":
        texts += _loop(calibration, fit)
    elif fit.test == "push":
        texts += _push(calibration, fit)
    elif fit.bound:
        does = "slides on this slope whatever the coefficient" if fit.bound == "at least" else "sticks without friction"
        texts.append(f"friction: {calibration.simulator} {does}; tan(theta) is taken, which it cannot follow.")
    return texts


def _left_out(calibration: Calibration, fit: Fit) -> list[str]:
    """A test that the simulator cannot follow, of a parameter that another test decides."""
    others = [each.test for each in calibration.fits if each.parameter == fit.parameter and each is not fit]
    symbol = SYMBOLS[fit.parameter]
    return [
        f"{fit.test}: {calibration.simulator} does not come to {_mm(fit.aim)} whatever {symbol} is; {symbol} is by the "
        f"{others[0]} alone, with which it comes to {_mm(fit.simulated)}. Is the reading right?"
    ]


def _disagreement(calibration: Calibration) -> list[str]:
    """Where sag and loop do not fit one rigidity, cloth does not bend in proportion."""
    if "disagreement" not in calibration.contributions:
        return []
    told = [fit for fit in calibration.fits if fit.parameter == "bending_rigidity"]
    alone = {fit.test: 1e6 * fit.alone for fit in told if fit.alone is not None}
    says = " and the ".join(f"{test} alone says {value:.3g}" for test, value in alone.items())
    taken = 1e6 * calibration.material.bending_rigidity
    return [
        f"bending: the {says} µN m: this cloth does not bend in proportion. {taken:.3g} is taken, each weighing as "
        "much as its readings tell; the uncertainty says how far they are apart."
    ]


def _elongation(calibration: Calibration, fit: Fit) -> list[str]:
    stiffness = calibration.material.stretch_stiffness
    if fit.bound:
        return [
            f"elongation: {_mm(fit.measured)} is within the error of reading it ({_mm(fit.uncertainty)}): the cloth is "
            f"stiffer than a ruler can tell, Y is at least {stiffness:.0f} N/m. Folding asks for no more."
        ]
    relative = calibration.relative("stretch_stiffness")
    if relative <= POOR:
        return []
    return [
        f"elongation: {_mm(fit.measured)} read to {_mm(fit.uncertainty)} tells Y to {100 * relative:.0f} % only. Read "
        "L1 and L2 more often, or hang the garment so that it is longer: elongation grows with the length squared."
    ]


def _sag(calibration: Calibration, fit: Fit) -> list[str]:
    material = calibration.material
    length = material.bending_length
    share = f"{_mm(fit.measured)} of a free length of {_mm(calibration.readings['free_length'].value)}"
    if fit.bound == "at most":
        return [
            f"sag: {share}: the cloth hangs straight down, which says only that B is at most "
            f"{1e6 * material.bending_rigidity:.2g} µN m (bending length {100 * length:.1f} cm or less). "
            + _limp(length, calibration)
        ]
    if fit.bound == "at least":
        return [
            f"sag: {share}: the cloth stands out level, which says only that B is at least "
            f"{1e6 * material.bending_rigidity:.2g} µN m (bending length {100 * length:.1f} cm or more). "
            f"Read it with a free length of {100 * BEST * length:.0f} cm or more."
        ]
    relative = calibration.relative("bending_rigidity")
    if relative <= POOR:
        return []
    return [f"sag: {share} tells B to {100 * relative:.0f} % only. {_limp(length, calibration)}"]


def _loop(calibration: Calibration, fit: Fit) -> list[str]:
    if fit.bound is None:
        return []
    return [
        f"loop: {_mm(fit.measured)} is as low as two layers: the cloth has no loop that a ruler could read, B is at "
        f"most {1e6 * calibration.material.bending_rigidity:.2g} µN m."
    ]


def _push(calibration: Calibration, fit: Fit) -> list[str]:
    compression = calibration.material.compression
    least = fit.alone or compression
    if fit.bound == "at most":
        return [
            f"push: the far edge stayed where it was to {_mm(fit.uncertainty)}: c is at most {compression:.2g}, and "
            "folding asks for no more. A shorter cloth or a longer push would tell."
        ]
    if fit.bound == "at least":
        return [
            f"push: the cloth slid as a whole, to {_mm(fit.uncertainty)}: c is at least {least:.2g}, and "
            f"{compression:.2g} is taken. A longer cloth would tell."
        ]
    return []


def _unused(calibration: Calibration) -> list[str]:
    if calibration.setup.push is None or calibration.fit("push") is not None:
        return []
    return [f"push: not used, {calibration.simulator} knows no compression: its cloth resists it as it does tension."]


def _restless(calibration: Calibration) -> list[str]:
    """Where simulated cloth creeps by as much as a ruler's reading is off."""
    errors = [fit.uncertainty for fit in calibration.fits if fit.unit == "m"]
    if not errors or calibration.unsettled < 0.5 * min(errors):
        return []
    return [
        f"{calibration.simulator}'s cloth does not come to rest: a reading still moved by {_mm(calibration.unsettled)} "
        "over the last quarter of its test, and its mean was taken."
    ]


def _limp(length: float, calibration: Calibration) -> str:
    """A free length that would tell, or the loop that would where that is too short to be held."""
    better = BEST * length
    if better >= SHORTEST:
        expected = 1e3 * better * tip(BEST**3)[1]
        return f"Read it with a free length of about {100 * better:.1f} cm: the edge should then sag {expected:.0f} mm."
    if calibration.setup.loop is not None:
        return f"A free length that would tell ({100 * better:.1f} cm) is too short to hold."
    height = HEIGHT * length + LIFT * calibration.material.thickness
    return (
        f"A free length that would tell ({100 * better:.1f} cm) is too short to hold. Fold it over itself on the table "
        f"instead, without pressing, and read the height of the loop, here {1e3 * height:.0f} mm or less: table "
        "[loop], height (`tatamu measure` says how)."
    )


def _substitution(calibration: Calibration) -> list[str]:
    """A search that did not end where the textbook does says something of the simulator."""
    textbook = calibration.textbook_friction
    if textbook is None:
        return []
    off = calibration.material.friction_table / textbook - 1.0
    if abs(off) < 0.02:
        return []
    return [
        f"friction: {calibration.simulator} needs a coefficient {100 * off:+.0f} % off tan(theta) = {textbook:.3f} to "
        "slide on this slope: an effective one, for this simulator."
    ]


def best_repeat(calibration: Calibration) -> tuple[str, list[tuple[str, float, float]]] | None:
    """The reading that is worth most to repeat, and the relative uncertainty of what it helps before and after.

    The gain of a reading is how much `MORE` repeats of it lower the sum of the relative variances.
    """
    rows = [PARAMETERS.index(name) for name in calibration.known]
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


def _mm(length: float) -> str:
    return f"{1e3 * length:.1f} mm"
