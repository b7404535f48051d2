"""Cloth in motion: recordings of a square cloth that a robot swings, by Luque et al.

Nothing is known of the cloth but its size, so what air does over its density is fitted, on six recordings; all others
are predicted.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from tatamu.instruments.oscillation import FreeSwing, swings
from tatamu.plate_in_air import rectangle_added_mass, steady_drag, turning_drag
from tatamu.presentation.chart import Chart, axis, traces
from tatamu.rollout import Rollout
from tatamu.simulators import capabilities
from tatamu.validation.real.bench import Bench, Experiment, Values
from tatamu.validation.real.pendulum import AirLaw, plate_swing
from tatamu.validation.real.recording import Recording, load_recordings
from tatamu.validation.real.section import Line, Section, Tabulated, reached
from tatamu.validation.real.sheet import SIDE, Sheet
from tatamu.validation.real.test import RealTest

FILE = "iri_cloth_motion.npz"
SESSION = "2021_06_23"
"""The session with the robot's poses."""
LEFT_OUT = ("calibration", "blooper")
"""Nothing moves in the first; the second is a run that the authors call failed."""
FITTED = ("n13_traj8_1", "n7_traj9_2", "n4_traj8_1", "n7_traj9_3", "n13_traj10_1", "n13_traj11_1")
"""Recordings on which what air does is fitted."""
NO_AIR = AirLaw()
START = (0.5, 1.0, 6.0)
"""Added mass, linear and quadratic drag with which a fit begins, all over the density."""
START_TURNING = (0.5, 0.3, 4.0)
"""Added mass, linear drag, and that of what turned around, likewise."""
START_SIZE = (0.3,)
"""Density [kg/m^2] with which a fit of it alone begins."""
STEP = 0.1
"""Of the differences in a fit, as a part of where it begins."""
EVALUATIONS = 3
"""Of the residuals' derivatives, in one fit."""
RECTANGLE = rectangle_added_mass(SIDE, SIDE)
"""Air that a plate of the cloth's size carries [kg/m^2]."""
TYPICAL = 0.01
"""Residuals beyond this [m] count less than by their squares: a camera's slip shall not decide."""
STILL = 0.05
"""A bar slower than this [m/s] lets the cloth swing freely."""
LEAST = 0.004
"""Smaller extremes of a swing are noise [m]."""
AMPLITUDES = (0.02, 0.04, 0.06)
"""Peak to peak, at which decrements are compared [m]."""
PERIOD, DECREMENT, SWING, NOISE = 0.03, 0.15, 9.0, 1.25
"""Goals: relative errors of period and decrement, RMS of the swing [mm], RMS of all nodes over the noise."""


@dataclass(frozen=True)
class Predicted:
    """One prediction of every recording."""

    name: str
    swings: Sequence[np.ndarray]
    """FreeSwing at the frames of each recording [m]."""
    all_nodes: Sequence[float] | None = None
    """RMS of all nodes of each recording [m]; None: it predicts the swing only."""
    lower: Sequence[float] | None = None
    """Of the lower edge."""
    fitted: str = "nothing"


class SwungCloth(RealTest):
    """Period, decrement and swing of a cloth in a robot's hands."""

    name = "motion"

    def load(self, data: Path) -> list[Recording]:
        """See `RealTest.load`."""
        return load_recordings(data / FILE, SESSION, LEFT_OUT)

    def simulations(self, measured: list[Recording], bench: Bench) -> int:
        """See `RealTest.simulations`."""
        return len(FITTED) * (2 + 1 + len(START)) * EVALUATIONS + 3 * len(measured)

    def run(self, measured: list[Recording], bench: Bench) -> Section:
        """See `RealTest.run`."""
        fitting = [recording for recording in measured if recording.name in FITTED]

        def swung(air: AirLaw) -> list[np.ndarray]:
            return _swings(_simulated(fitting, air, bench))

        plate_air = fit(lambda air: [plate_swing(each, air, SIDE) for each in fitting], fitting, _law, START)
        plate = [plate_swing(each, plate_air, SIDE) for each in measured]
        small_air = fit(lambda air: [plate_swing(each, air, SIDE) for each in fitting], fitting, of_size, START_SIZE)
        small = [plate_swing(each, small_air, SIDE) for each in measured]
        predictions = [
            Predicted("rigid plate that hangs straight", [np.zeros(len(each.times)) for each in measured]),
            Predicted("plate of one degree of freedom", plate, fitted=_said(plate_air)),
            Predicted("the same, air of a plate of that size", small, fitted=_by_size(small_air)),
            _cloth(f"{bench.simulator}, without air", measured, NO_AIR, bench),
        ]
        if capabilities(bench.simulator).directional_air:
            sized = fit(swung, fitting, of_size, START_SIZE)
            predictions.append(
                _cloth(f"{bench.simulator}, air of a plate of that size", measured, sized, bench, _by_size(sized))
            )
            free = fit(swung, fitting, _turning, START_TURNING)
        else:
            free = fit(swung, fitting, lambda numbers: AirLaw(linear=float(numbers[0])), START[1:2])
        predictions.append(_cloth(f"{bench.simulator}, air fitted", measured, free, bench, _said(free)))
        return Section(
            name=self.name,
            title="Cloth in a robot's hands",
            method=(
                f"{len(measured)} recordings of a cloth of 0.3 m that hangs from a bar. The robot's own poses drive "
                "the bar; each frame of the camera has a clock of its own, on which its upper corners are where the "
                f"robot has them. What air does was fitted on {len(fitting)} recordings; all figures are medians over "
                f"the {len(measured) - len(fitting)} others. The swing is the lower edge ahead of the upper one, "
                "across the bar. The cloth's own stiffness does not show in it."
            ),
            tables=[
                Tabulated("real: swing", [_line(each, measured) for each in predictions]),
                Tabulated("real: period", _periods(predictions, measured)),
            ],
            beat=(
                "The plate of one degree of freedom, fitted on the same recordings; and 3 to 9 mm, by which repeats of "
                "one path of the robot differ. The authors' linear models are fitted to each recording, and a rigid "
                "plate that follows the hand is as good on their measure: it proves little."
            ),
            goal=_goal(predictions[1], predictions[-1], measured),
            silent=(
                "Density and fabric are not stated, so that only ratios to the density are known: at least one number "
                "is fitted. No table, no fold, no contact: no public measurement of a real "
                "fold with contact was found."
            ),
            charts=_charts(predictions, measured),
        )


def fit(
    predict: Callable[[AirLaw], list[np.ndarray]],
    recordings: Sequence[Recording],
    law: Callable[[np.ndarray], AirLaw],
    start: Sequence[float],
) -> AirLaw:
    """Air by least squares on the swing, outliers counting less.

    Args:
        predict: Swings of the recordings in that air.
        recordings: What was measured.
        law: The air of some numbers.
        start: The numbers with which the fit begins.
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


def _law(numbers: np.ndarray) -> AirLaw:
    return AirLaw(*(float(value) for value in numbers))


def of_size(numbers: np.ndarray) -> AirLaw:
    """The air of a rigid plate of the cloth's size, over a density [kg/m^2], the only number."""
    density = float(numbers[0])
    return AirLaw(RECTANGLE / density, 0.0, steady_drag() / density, turning_drag(SIDE) / density)


def _turning(numbers: np.ndarray) -> AirLaw:
    added_mass, linear, turning = (float(value) for value in numbers)
    return AirLaw(added_mass, linear, 0.0, turning)


def _differences(residuals: Callable[[np.ndarray], np.ndarray], numbers: np.ndarray) -> np.ndarray:
    here = residuals(numbers)
    return np.column_stack([(residuals(numbers + STEP * unit) - here) / STEP for unit in np.eye(len(numbers))])


def _simulated(recordings: Sequence[Recording], air: AirLaw, bench: Bench) -> list[Values]:
    return bench.measure([_experiment(recording, air) for recording in recordings])


def _experiment(recording: Recording, air: AirLaw) -> Experiment:
    sheet = Sheet(recording)

    def read(rollout: Rollout) -> Values:
        nodes = sheet.nodes(rollout)
        swing = recording.swing_of(nodes)
        off = ((nodes - recording.nodes) ** 2).sum(axis=3)
        return {
            "swing": [None if np.isnan(value) else round(float(value), 6) for value in swing - np.nanmedian(swing)],
            "all": float(np.sqrt(off[:, :-1][recording.good[:, :-1]].mean())),
            "lower": float(np.sqrt(off[:, 0][recording.good[:, 0]].mean())),
        }

    seen = hashlib.sha256(recording.nodes.tobytes()).hexdigest()[:12]
    return Experiment(recording.name, sheet.scene(air), f"motion {seen}", read)


def _swings(values: Sequence[Values]) -> list[np.ndarray]:
    """Swings of rollouts [m]; of one that failed infinite ones would say nothing, so that it is an error."""
    return [np.array(each["swing"], dtype=float) for each in values]


def _cloth(name: str, measured: Sequence[Recording], air: AirLaw, bench: Bench, fitted: str = "nothing") -> Predicted:
    values = _simulated(measured, air, bench)
    return Predicted(
        name, _swings(values), [each["all"] for each in values], [each["lower"] for each in values], fitted
    )


def _said(air: AirLaw) -> str:
    """The numbers that are not zero."""
    parts = {
        f"added mass {air.added_mass:.2f} ρ": air.added_mass,
        f"linear drag {air.linear:.2f} ρ/s": air.linear,
        f"quadratic drag {air.quadratic:.1f} ρ/m": air.quadratic,
        f"turning drag {air.turning:.2f} ρ/m^(2/3)": air.turning,
    }
    return ", ".join(text for text, value in parts.items() if value > 0.0)


def _by_size(air: AirLaw) -> str:
    return f"density {RECTANGLE / air.added_mass:.2f} kg/m²; air by size: {_said(air)}"


def _held_out(measured: Sequence[Recording]) -> list[int]:
    return [k for k, recording in enumerate(measured) if recording.name not in FITTED]


def _off(prediction: Predicted, measured: Sequence[Recording]) -> list[float]:
    """RMS error of the swing of each recording that was not fitted [m]."""
    errors = [prediction.swings[k] - measured[k].swing for k in _held_out(measured)]
    return [float(np.sqrt(np.nanmean(error**2))) for error in errors]


def _line(prediction: Predicted, measured: Sequence[Recording]) -> Line:
    off = _off(prediction, measured)
    held = _held_out(measured)
    noise = np.median([measured[k].noise for k in held])

    def nodes(values: Sequence[float] | None) -> str:
        return "–" if values is None else f"{1e3 * np.median([values[k] for k in held]):.1f}"

    return {
        "prediction": prediction.name,
        "fitted": prediction.fitted,
        "swing, median RMS [mm]": f"{1e3 * np.median(off):.1f}",
        "worst": f"{1e3 * max(off):.1f}",
        "all nodes [mm]": nodes(prediction.all_nodes),
        "lower edge [mm]": nodes(prediction.lower),
        "camera's noise [mm]": f"{1e3 * noise:.1f}",
    }


def free_swings(recording: Recording, swing: np.ndarray) -> list[FreeSwing]:
    """The swings of a signal at the recording's frames during which the bar is still."""
    times, corners = recording.path
    speed = np.linalg.norm(np.gradient(corners.mean(axis=1), times, axis=0), axis=1)
    seen = np.isfinite(swing)
    order = np.argsort(recording.clock[seen])  # clocks of their own may overtake one another
    found = swings(recording.clock[seen][order], swing[seen][order], LEAST)
    return [each for each in found if speed[(times >= each.start) & (times <= each.end)].max(initial=0.0) < STILL]


def _free_motion(signals: Sequence[np.ndarray], measured: Sequence[Recording]) -> tuple[float, np.ndarray, int]:
    """Median period [s], decrements at `AMPLITUDES`, and the number of swings."""
    found = [each for recording, swing in zip(measured, signals, strict=True) for each in free_swings(recording, swing)]
    fading = [each for each in found if np.isfinite(each.decrement)]
    if len(fading) < 3:
        return (float(np.median([each.period for each in found])) if found else np.nan), np.full(3, np.nan), len(found)
    decrements = decrement_line(np.array([(each.amplitude, each.decrement) for each in fading]))
    return float(np.median([each.period for each in found])), decrements, len(found)


def decrement_line(fading: np.ndarray) -> np.ndarray:
    """Decrements at `AMPLITUDES`, by the line through amplitudes [m] and decrements of swings, shape (k, 2)."""
    amplitudes, decrements = fading.T
    return np.asarray(np.polyval(np.polyfit(amplitudes, decrements, 1), np.array(AMPLITUDES)))


def _periods(predictions: Sequence[Predicted], measured: Sequence[Recording]) -> list[Line]:
    rows = [("measured", [recording.swing for recording in measured])]
    rows += [(each.name, list(each.swings)) for each in predictions[1:]]
    lines: list[Line] = []
    for name, signals in rows:
        period, decrements, count = _free_motion(signals, measured)
        line = {"": name, "free swings": str(count), "period [s]": f"{period:.2f}"}
        for amplitude, decrement in zip(AMPLITUDES, decrements, strict=True):
            line[f"decrement at {1e3 * amplitude:.0f} mm"] = f"{decrement:.2f}"
        lines.append(line)
    return lines


def _goal(plate: Predicted, cloth: Predicted, measured: Sequence[Recording]) -> str:
    period, decrements, _ = _free_motion([recording.swing for recording in measured], measured)
    got, faded, _ = _free_motion(cloth.swings, measured)
    swing, other = (1e3 * float(np.median(_off(each, measured))) for each in (cloth, plate))
    held = _held_out(measured)
    noise = float(np.median([measured[k].noise for k in held]))
    everything = float(np.median([(cloth.all_nodes or [])[k] for k in held])) / noise
    fading = np.abs(faded / decrements - 1.0)
    return (
        f"Period within {100 * PERIOD:g} %: {reached(abs(got / period - 1.0) <= PERIOD)} "
        f"({100 * (got / period - 1.0):+.1f} %); decrement within {100 * DECREMENT:g} % at three amplitudes: "
        f"{reached(bool((fading <= DECREMENT).all()))} ({', '.join(f'{100 * each:.0f} %' for each in fading)}); swing "
        f"within {SWING:g} mm: {reached(swing <= SWING)} ({swing:.1f} mm); all nodes within {NOISE:g} of the noise: "
        f"{reached(everything <= NOISE)} ({everything:.2f}); no recording was left out. Beats the rigid plate: "
        f"{'yes' if swing < 1e3 * np.median([np.sqrt(np.nanmean(measured[k].swing ** 2)) for k in held]) else 'no'}; "
        f"the plate of one degree of freedom: {'yes' if swing < other else 'no'} ({other:.1f} mm)."
    )


def _charts(predictions: Sequence[Predicted], measured: Sequence[Recording]) -> list[Chart]:
    """The measured and the predicted swing of the held-out recording whose error is the median one."""
    held = _held_out(measured)
    off = _off(predictions[-1], measured)
    place = held[int(np.argsort(off)[len(off) // 2])]
    shown = [("measured", measured[place].swing, "@ink")]
    shown += [(each.name, each.swings[place], f"@series-{k}") for k, each in enumerate(predictions[1:])]
    time = [round(float(value), 3) for value in measured[place].clock]
    lines = [
        {
            "mode": "lines",
            "name": name,
            "x": time,
            "y": [None if np.isnan(value) else round(1e3 * float(value), 2) for value in swing],
            "line": {"color": colour, "width": 2.2 if name == "measured" else 1.3},
        }
        for name, swing, colour in shown
    ]
    plot = traces(lines, xaxis=axis("time [s]"), yaxis=axis("swing [mm]"), showlegend=True)
    return [Chart(f"FreeSwing in {measured[place].name}", plot, "not fitted; the median of those", kind="tall")]
