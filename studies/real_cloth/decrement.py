"""Evaluates the damping of a cloth that a robot swings, and compares the damping with models of air.

    python -m studies.real_cloth.decrement --data DATA

The logarithmic decrement describes how fast a swing decays. The result is a table. It has the measured decrements at
several amplitudes, and their scatter, which is estimated by bootstrap over the recordings. For comparison, the table
has the decrements of a stiff plate with several models of air. In these models, the drag is linear, quadratic, or
larger just after the motion has changed its direction.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from benchmarks.tables import markdown

from studies.real_cloth.fading import AMPLITUDES, decrement_line, free_swings
from studies.real_cloth.fitted_air import START_SIZE, fit, of_size
from studies.real_cloth.motion import FILE, FITTED, LEFT_OUT, SESSION
from studies.real_cloth.pendulum import AirLaw, plate_swing
from studies.real_cloth.recording import Recording, load_recordings
from studies.real_cloth.sheet import SIDE

DRAWS = 2000
LAWS = [AirLaw(0.5, linear, quadratic) for linear, quadratic in ((1.0, 5.6), (0.6, 8.0), (0.3, 11.0), (0.0, 14.0))]
LAWS += [AirLaw(0.5, linear, quadratic) for linear, quadratic in ((0.5, 15.0), (0.0, 18.0), (0.0, 25.0))]
"""Sets of coefficients of the forces of air (added mass and drag).

The first set is from the fit to the swing. The following sets have more and more quadratic drag."""
FREE = (0.4, 2.0, 4.0)
"""Added mass, quadratic drag and turning drag with which the fit of the effects of air starts."""
Row = dict[str, str]


def faded(recordings: list[Recording], signals: list[np.ndarray]) -> list[np.ndarray]:
    """Return the amplitudes [m] and decrements of the cloth's free swings in each recording.

    A recording with k free swings has an array of shape (k, 2).
    """
    found = [free_swings(recording, signal) for recording, signal in zip(recordings, signals, strict=True)]
    return [
        np.array([(one.amplitude, one.decrement) for one in each if np.isfinite(one.decrement)]).reshape(-1, 2)
        for each in found
    ]


def _row(
    name: str, decrements: np.ndarray, errors: np.ndarray | None = None, off: tuple[float, float] | None = None
) -> Row:
    shown = [f"{value:.2f}" for value in decrements]
    if errors is not None:
        shown = [f"{value} ± {error:.2f}" for value, error in zip(shown, errors, strict=True)]
    named = {f"decrement at {1e3 * at:.0f} mm": value for at, value in zip(AMPLITUDES, shown, strict=True)}
    fitted, others = ("–", "–") if off is None else (f"{1e3 * value:.1f}" for value in off)
    return {"": name, **named, "swing, those fitted [mm]": fitted, "swing, others [mm]": others}


def measured(recordings: list[Recording]) -> Row:
    """Return the table's row of decrements that were measured, with their scatter."""
    each = faded(recordings, [recording.swing for recording in recordings])
    random = np.random.default_rng(0)
    lines = []
    for _ in range(DRAWS):
        drawn = np.concatenate([each[k] for k in random.integers(0, len(each), len(each))])
        if len(drawn) > 3:
            lines.append(decrement_line(drawn))
    together = np.concatenate(each)
    told = sum(len(one) > 0 for one in each)
    return _row(f"measured: {len(together)} swings, {told} recordings", decrement_line(together), np.std(lines, axis=0))


def predicted(recordings: list[Recording], air: AirLaw) -> Row:
    """Return the table's row of decrements of a stiff plate that swings in air.

    `air` has the added mass and the drag of air.
    """
    signals = [plate_swing(recording, air, SIDE) for recording in recordings]
    off = [float(np.sqrt(np.nanmean((s - r.swing) ** 2))) for s, r in zip(signals, recordings, strict=True)]
    fitted, others = (
        float(np.median([value for value, r in zip(off, recordings, strict=True) if (r.name in FITTED) == wanted]))
        for wanted in (True, False)
    )
    name = f"plate: {air.added_mass:.2g} ρ, {air.linear:.2g} ρ/s, {air.quadratic:.2g} ρ/m"
    name += f", turning {air.turning:.2g} ρ/m^(2/3)" if air.turning else ""
    return _row(name, decrement_line(np.concatenate(faded(recordings, signals))), None, (fitted, others))


def main() -> None:
    """Parse the command line, and print the table of decrements."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    options = parser.parse_args()
    recordings = load_recordings(options.data / FILE, SESSION, LEFT_OUT)
    fitting = [recording for recording in recordings if recording.name in FITTED]

    def swung(air: AirLaw) -> list[np.ndarray]:
        return [plate_swing(each, air, SIDE) for each in fitting]

    sized = fit(swung, fitting, of_size, START_SIZE)
    free = fit(swung, fitting, lambda parts: AirLaw(parts[0], 0.0, parts[1], parts[2]), FREE)
    table = markdown([measured(recordings), *(predicted(recordings, air) for air in (*LAWS, sized, free))])
    print(table)


if __name__ == "__main__":
    main()
