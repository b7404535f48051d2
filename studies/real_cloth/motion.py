"""Predicts how a square cloth moves that a robot swings, and compares with recordings by Luque et al.

Only the size of the cloth is known, and the effects of air depend on its density. Therefore the effects of air divided
by the density are fitted to six recordings. The motion in all other recordings is predicted.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.real_cloth.alignment import UNMOVED, Displacement, Pairs
from studies.real_cloth.bench import Bench, Experiment, Values
from studies.real_cloth.fading import AMPLITUDES, free_motion
from studies.real_cloth.fitted_air import (
    EVALUATIONS,
    START,
    START_SIZE,
    START_TURNING,
    fit,
    linear,
    of_size,
    said,
    said_by_size,
    steady,
    turning,
)
from studies.real_cloth.pendulum import AirLaw, plate_nodes, plate_swing
from studies.real_cloth.recording import Recording, load_recordings
from studies.real_cloth.section import Line, Section, Tabulated, reached
from studies.real_cloth.sheet import SIDE, Sheet
from studies.real_cloth.test import RealTest
from tatamu.base.errors import InputError, SimulationError
from tatamu.show.chart import Chart, axis, traces
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.simulators import capabilities

FILE = "iri_cloth_motion.npz"
SESSION = "2021_06_23"
"""Name of a session of recordings of a swung cloth, in which the robot's poses were recorded too."""
LEFT_OUT = ("calibration", "blooper")
"""Names of recordings of a swung cloth that are left out. In the recording "calibration", nothing moves. The authors
say that the recording "blooper" failed."""
FITTED = ("n13_traj8_1", "n7_traj9_2", "n4_traj8_1", "n7_traj9_3", "n13_traj10_1", "n13_traj11_1")
"""Names of those recordings of a swung cloth to which the effects of air are fitted."""
NO_AIR = AirLaw()
PERIOD, DECREMENT, SWING, NOISE = 0.03, 0.15, 9.0, 1.25
"""Largest errors of a predicted swing that meet four goals. PERIOD and DECREMENT are relative errors of the period and
of the decrement. SWING is the RMS error of the swing [mm]. NOISE is the RMS error of all nodes, divided by the noise of
the camera."""


@dataclass(frozen=True)
class Predicted:
    """A model's predictions for all recordings of a swung cloth."""

    name: str
    swings: Sequence[np.ndarray]
    """Predicted swing of the cloth's lower edge at the frames of each recording [m]."""
    free: Sequence[Pairs]
    """Means over pairs of predicted and seen positions of the cloth's nodes, for each recording. The pairs are of all
    nodes except those at the held edge."""
    lower: Sequence[Pairs]
    """Means over pairs of predicted and seen positions of the cloth's nodes, for each recording. The pairs are of the
    nodes at the lower edge."""
    fitted: str = "nothing"

    def camera(self, measured: Sequence[Recording]) -> Displacement:
        """Return the displacement of the camera with which the predictions fit the recordings `FITTED` best."""
        fitting = [pairs for pairs, recording in zip(self.free, measured, strict=True) if recording.name in FITTED]
        return Pairs.mean(fitting).displacement()


class SwungCloth(RealTest):
    """The test that predicts the swing, the period and the decrement of a cloth that a robot swings."""

    name = "motion"

    def load(self, data: Path) -> list[Recording]:
        recordings = load_recordings(data / FILE, SESSION, LEFT_OUT)
        missing = set(FITTED) - {each.name for each in recordings}
        if missing:
            raise InputError(f"{data / FILE}: must hold the recordings {', '.join(FITTED)}, lacks {min(missing)}")
        return recordings

    def simulations(self, measured: list[Recording], bench: Bench) -> int:
        return len(FITTED) * (2 + 1 + len(START)) * EVALUATIONS + 3 * len(measured)

    def run(self, measured: list[Recording], bench: Bench) -> Section:
        fitting = [recording for recording in measured if recording.name in FITTED]

        def swung(air: AirLaw) -> list[np.ndarray]:
            return swings_in(air, fitting, bench)

        def of_plate(air: AirLaw) -> list[np.ndarray]:
            return [plate_swing(each, air, SIDE) for each in fitting]

        plate = fit(of_plate, fitting, steady, START)
        small = fit(of_plate, fitting, of_size, START_SIZE)
        predictions = [
            _plate("rigid plate that hangs straight", measured, [np.zeros(len(each.times)) for each in measured]),
            _swung_plate("plate of one degree of freedom", measured, plate, said(plate)),
            _swung_plate("the same, air of a plate of that size", measured, small, said_by_size(small)),
            _cloth(f"{bench.simulator}, without air", measured, NO_AIR, bench),
        ]
        if capabilities(bench.simulator).directional_air:
            sized = fit(swung, fitting, of_size, START_SIZE)
            predictions.append(
                _cloth(f"{bench.simulator}, air of a plate of that size", measured, sized, bench, said_by_size(sized))
            )
            free = fit(swung, fitting, turning, START_TURNING)
        else:
            free = fit(swung, fitting, linear, START[1:2])
        predictions.append(_cloth(f"{bench.simulator}, air fitted", measured, free, bench, said(free)))
        return Section(
            name=self.name,
            title="Cloth in a robot's hands",
            method=(
                f"{len(measured)} recordings show a cloth of 0.3 m that hangs from a bar. The simulated bar follows "
                "the recorded poses of the robot. The clock of the camera is corrected so that the upper corners of "
                f"the cloth are where the robot holds them. The air was fitted on {len(fitting)} recordings; all "
                f"figures are medians over the {len(measured) - len(fitting)} others. The swing is the distance by "
                "which the lower edge is ahead of the upper one, across the bar; it does not depend on the stiffness "
                "of the cloth. Camera displaced: the predictions are moved and turned about the middle of the bar, "
                "because the place of a camera is known only roughly. This displacement is the same for all "
                f"recordings, and was fitted on the same {len(fitting)}."
            ),
            tables=[
                Tabulated("real: swing", [_line(each, measured) for each in predictions]),
                Tabulated("real: period", _periods(predictions, measured)),
            ],
            beat=(
                "The plate with one degree of freedom, fitted on the same recordings; and 3 to 9 mm, by which repeats "
                "of one path of the robot differ. The authors fit linear models to each recording. By their measure a "
                "rigid plate that follows the hand is as good, so the measure shows little."
            ),
            goal=_goal(predictions[1], predictions[-1], measured),
            silent=(
                "Density and fabric are not stated, so only ratios to the density are known, and at least one number "
                "must be fitted. The recordings have no table, no fold and no contact; no public measurement of a real "
                "fold with contact was found."
            ),
            charts=_charts(predictions, measured),
        )


def swings_in(air: AirLaw, recordings: Sequence[Recording], bench: Bench) -> list[np.ndarray]:
    """Simulate recordings of a swung cloth, and return how far its lower edge swings at each frame [m].

    `air` has the added mass and the drag of air.
    """
    return _swings(_simulated(recordings, air, bench))


def _simulated(recordings: Sequence[Recording], air: AirLaw, bench: Bench) -> list[Values]:
    values = bench.measure([_experiment(recording, air) for recording in recordings])
    for recording, each in zip(recordings, values, strict=True):
        if "failed" in each:  # otherwise a recording would be missing without notice
            raise SimulationError(f"{recording.name}: {each['failed']}")
    return values


def _experiment(recording: Recording, air: AirLaw) -> Experiment:
    sheet = Sheet(recording)

    def read(rollout: Rollout) -> Values:
        nodes = sheet.nodes(rollout)
        swing = recording.swing_of(nodes)
        free, lower = _seen(recording, nodes)
        return {
            "swing": [None if np.isnan(value) else round(float(value), 6) for value in swing - np.nanmedian(swing)],
            "free": free.plain(),
            "lower": lower.plain(),
        }

    seen = hashlib.sha256(recording.nodes.tobytes()).hexdigest()[:12]
    return Experiment(recording.name, sheet.scene(air), f"nodes of {seen}", read)


def _swings(values: Sequence[Values]) -> list[np.ndarray]:
    """Return the swing in each simulation [m], from the values that were read from the simulations."""
    return [np.array(each["swing"], dtype=float) for each in values]


def _cloth(name: str, measured: Sequence[Recording], air: AirLaw, bench: Bench, fitted: str = "nothing") -> Predicted:
    values = _simulated(measured, air, bench)
    free, lower = ([Pairs.from_plain(each[part]) for each in values] for part in ("free", "lower"))
    return Predicted(name, _swings(values), free, lower, fitted)


def _swung_plate(name: str, measured: Sequence[Recording], air: AirLaw, fitted: str) -> Predicted:
    return _plate(name, measured, [plate_swing(each, air, SIDE) for each in measured], fitted)


def _plate(
    name: str, measured: Sequence[Recording], swings: Sequence[np.ndarray], fitted: str = "nothing"
) -> Predicted:
    seen = [_seen(each, plate_nodes(each, swing, SIDE)) for each, swing in zip(measured, swings, strict=True)]
    return Predicted(name, swings, [free for free, _ in seen], [lower for _, lower in seen], fitted)


def _seen(recording: Recording, nodes: np.ndarray) -> tuple[Pairs, Pairs]:
    """Return means over pairs of predicted and seen positions of the cloth's nodes in a recording.

    The first result is for all nodes except those at the held edge. The second result is for the nodes at the lower
    edge.
    """
    places, seen = nodes - recording.middle, recording.nodes - recording.middle
    free, lower = (recording.good[:, rows] for rows in (slice(None, -1), slice(1)))
    return Pairs.of(places[:, :-1][free], seen[:, :-1][free]), Pairs.of(places[:, :1][lower], seen[:, :1][lower])


def _held_out(measured: Sequence[Recording]) -> list[int]:
    return [k for k, recording in enumerate(measured) if recording.name not in FITTED]


def _off(prediction: Predicted, measured: Sequence[Recording]) -> list[float]:
    """Return the RMS error of the predicted swing for each recording that was not used for fitting [m]."""
    errors = [prediction.swings[k] - measured[k].swing for k in _held_out(measured)]
    return [float(np.sqrt(np.nanmean(error**2))) for error in errors]


def _line(prediction: Predicted, measured: Sequence[Recording]) -> Line:
    off = _off(prediction, measured)
    return {
        "prediction": prediction.name,
        "fitted": prediction.fitted,
        "swing, median RMS [mm]": f"{1e3 * np.median(off):.1f}",
        "worst": f"{1e3 * max(off):.1f}",
        "all nodes [mm]": f"{1e3 * _distance(prediction.free, measured):.1f}",
        "camera displaced": f"{1e3 * _distance(prediction.free, measured, prediction.camera(measured)):.1f}",
        "lower edge [mm]": f"{1e3 * _distance(prediction.lower, measured):.1f}",
        "camera's noise [mm]": f"{1e3 * _noise(measured):.1f}",
    }


def _distance(pairs: Sequence[Pairs], measured: Sequence[Recording], by: Displacement = UNMOVED) -> float:
    """Return the median distance between predicted and seen nodes of the cloth [m].

    The median is over the recordings that were not used for fitting.
    """
    return float(np.median([pairs[k].distance(by) for k in _held_out(measured)]))


def _noise(measured: Sequence[Recording]) -> float:
    """Return the median noise of the camera over the recordings that were not used for fitting [m]."""
    return float(np.median([measured[k].noise for k in _held_out(measured)]))


def _periods(predictions: Sequence[Predicted], measured: Sequence[Recording]) -> list[Line]:
    rows = [("measured", [recording.swing for recording in measured])]
    rows += [(each.name, list(each.swings)) for each in predictions[1:]]
    lines: list[Line] = []
    for name, signals in rows:
        period, decrements, count = free_motion(signals, measured)
        line = {"": name, "free swings": str(count), "period [s]": f"{period:.2f}"}
        for amplitude, decrement in zip(AMPLITUDES, decrements, strict=True):
            line[f"decrement at {1e3 * amplitude:.0f} mm"] = f"{decrement:.2f}"
        lines.append(line)
    return lines


def _goal(plate: Predicted, cloth: Predicted, measured: Sequence[Recording]) -> str:
    period, decrements, _ = free_motion([recording.swing for recording in measured], measured)
    got, faded, _ = free_motion(cloth.swings, measured)
    swing, other = (1e3 * float(np.median(_off(each, measured))) for each in (cloth, plate))
    held = _held_out(measured)
    camera = cloth.camera(measured)
    apart, displaced = (_distance(cloth.free, measured, by) / _noise(measured) for by in (UNMOVED, camera))
    fading = np.abs(faded / decrements - 1.0)
    return (
        f"Period within {100 * PERIOD:g} %: {reached(abs(got / period - 1.0) <= PERIOD)} "
        f"({100 * (got / period - 1.0):+.1f} %); decrement within {100 * DECREMENT:g} % at three amplitudes: "
        f"{reached(bool((fading <= DECREMENT).all()))} ({', '.join(f'{100 * each:.0f} %' for each in fading)}); swing "
        f"within {SWING:g} mm: {reached(swing <= SWING)} ({swing:.1f} mm); all nodes within {NOISE:g} of the noise: "
        f"{reached(apart <= NOISE)} ({apart:.2f}), with the camera displaced (by {camera}): "
        f"{reached(displaced <= NOISE)} ({displaced:.2f}); no recording was left out. Beats the rigid plate: "
        f"{'yes' if swing < 1e3 * np.median([np.sqrt(np.nanmean(measured[k].swing ** 2)) for k in held]) else 'no'}; "
        f"the plate of one degree of freedom: {'yes' if swing < other else 'no'} ({other:.1f} mm)."
    )


def _charts(predictions: Sequence[Predicted], measured: Sequence[Recording]) -> list[Chart]:
    """Return a chart of the measured and predicted swings of a typical recording.

    It is the recording with the median error among all recordings that were not used for fitting.
    """
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
    return [Chart(f"Swing in {measured[place].name}", plot, "not fitted; the median of those", kind="tall")]
