"""Finds causes for the distances between simulated nodes of a swung cloth and the nodes that a camera saw.

    python -m studies.real_cloth.seen_nodes --data DATA --out runs/real-cloth

The simulator `native` has fitted effects of air, as in the test `motion` of `studies.real_cloth`. Its nodes are
compared with the seen nodes, without and with corrections:

- for a displaced camera,
- for another size of the cloth,
- for a shift in time,
- for a motion of the whole cloth.

Simulations that are kept in OUT are not run again.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from benchmarks.tables import markdown
from scipy.optimize import minimize_scalar

from studies.real_cloth.alignment import Displacement, Pairs
from studies.real_cloth.bench import Bench
from studies.real_cloth.fitted_air import START_TURNING, fit, turning
from studies.real_cloth.motion import FILE, FITTED, LEFT_OUT, SESSION, swings_in
from studies.real_cloth.recording import Recording, load_recordings
from studies.real_cloth.sheet import Sheet
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.simulators import simulate

SIMULATOR = "native"
LATENESS = np.arange(-0.1, 0.11, 0.02)
"""Shifts in time of the predicted motion of a cloth that are tried [s]."""
SHORTEST = 0.9
"""Smallest height of the cloth that is tried, as a fraction of the assumed height of 0.3 m.

The largest height that is tried is 1.1 times the assumed height.
"""


@dataclass(frozen=True)
class Seen:
    """A recording of a swung cloth, and its simulation.

    All positions are relative to the middle of the bar that holds the cloth.
    """

    recording: Recording
    rollout: Rollout

    @cached_property
    def seen(self) -> np.ndarray:
        """Positions of the cloth's n x n nodes that the camera saw at f frames [m], shape (f, n, n, 3).

        A lost or misplaced node is NaN.
        """
        return np.where(self.recording.good[..., None], self.recording.nodes - self.recording.middle, np.nan)

    @property
    def size(self) -> int:
        """Number of nodes in a row of the camera's grid."""
        return self.recording.nodes.shape[1]

    @cached_property
    def predicted(self) -> np.ndarray:
        """Predicted positions of the cloth's n x n nodes at the camera's f frames [m], shape (f, n, n, 3)."""
        return self.later(0.0)

    def later(self, late: float) -> np.ndarray:
        """Return the predicted positions of the cloth's nodes if the whole motion is later by `late` [s]."""
        return Sheet(self.recording).nodes(self.rollout, late) - self.recording.middle

    @cached_property
    def axes(self) -> np.ndarray:
        """Unit vectors at each of f frames, shape (f, 3, 3): across the bar that holds the cloth, along it, and up."""
        across = self.recording.normal(self.recording.clock)
        up = np.tile([0.0, 0.0, 1.0], (len(across), 1))
        return np.stack([across, np.cross(across, up), up], axis=1)

    def pairs(self, height: float = 1.0) -> Pairs:
        """Return means over pairs of predicted and seen positions of the cloth's nodes, except nodes at the held edge.

        The predicted positions are multiplied by `height`, the tried height of the cloth divided by its assumed height.
        """
        seen = self.seen[:, :-1]
        good = np.isfinite(seen).all(axis=3)
        return Pairs.of(height * self.predicted[:, :-1][good], seen[good])


Change = Callable[[Seen], np.ndarray]
"""Function that returns the errors of a recording's nodes after a correction [m], shape (f, n, n, 3).

The recording has f frames, and the camera's grid has n x n nodes.
"""


def displaced(by: Displacement, height: float = 1.0) -> Change:
    """Return a correction of predicted nodes for a camera that is displaced.

    The predicted positions are also multiplied by `height`, the tried height of the cloth divided by its assumed
    height.
    """
    return lambda each: height * each.predicted @ by.rotation.T + by.translation - each.seen


def unmoved(each: Seen) -> np.ndarray:
    """Return the errors of the predicted nodes of a recording without a correction."""
    return each.predicted - each.seen


def by_grid(fitting: list[Seen]) -> tuple[str, Change]:
    """Return a correction of predicted nodes for a displaced camera.

    The displacement is different for each size of the camera's grid of nodes. The first result is a text with these
    displacements.
    """
    sizes = sorted({each.size for each in fitting})
    found = {size: Pairs.mean([each.pairs() for each in fitting if each.size == size]).displacement() for size in sizes}
    return ", ".join(str(by) for by in found.values()), lambda each: displaced(found[each.size])(each)


def by_itself(each: Seen) -> np.ndarray:
    """Return the errors of a recording's predicted nodes after the best displacement of the camera.

    The displacement is fitted to this recording only.
    """
    return displaced(each.pairs().displacement())(each)


def per_node(each: Seen) -> np.ndarray:
    """Return the errors of a recording's predicted nodes, minus the mean error of each node over all frames."""
    off = unmoved(each)
    return np.asarray(off - np.nanmean(off, axis=0))


def per_frame(each: Seen) -> np.ndarray:
    """Return the errors of a recording's predicted nodes, minus the mean error of all nodes in each frame.

    The remaining errors are errors of the cloth's shape.
    """
    off = unmoved(each)
    return np.asarray(off - np.nanmean(off, axis=(1, 2), keepdims=True))


def later(each: Seen) -> np.ndarray:
    """Return the errors of a recording's predicted nodes after the best shift in time.

    The shift is fitted to this recording only.
    """
    errors = [each.later(float(late)) - each.seen for late in LATENESS]
    return min(errors, key=lambda off: float(rms(off[:, :-1])))


def rms(off: np.ndarray) -> float:
    """Return the root mean square (RMS) length of error vectors, shape (.., 3) [m]. Vectors with NaN are left out."""
    return float(np.sqrt(np.nanmean((off**2).sum(axis=-1))))


def row(name: str, numbers: str, change: Change, held_out: list[Seen]) -> dict[str, str]:
    """Return the table's row of a correction, with the errors of nodes that remain.

    The errors are medians over the recordings that were not used for fitting.
    """
    found = []
    for each in held_out:
        off = change(each)
        parts = np.einsum("fax,fijx->fija", each.axes, off[:, :-1])
        found.append(
            [rms(off[:, :-1]), *(rms(parts[..., [axis]]) for axis in range(3)), rms(off[:, 0]), rms(off[:, -1])]
        )
    everything, *others = 1e3 * np.median(found, axis=0)
    noise = 1e3 * float(np.median([each.recording.noise for each in held_out]))
    names = ("across the bar", "along it", "up", "lower edge", "held edge")
    return {
        "compared": name,
        "fitted": numbers,
        "all nodes [mm]": f"{everything:.1f}",
        "over the noise": f"{everything / noise:.2f}",
        **{what: f"{value:.1f}" for what, value in zip(names, others, strict=True)},
    }


def table(measured: list[Seen]) -> list[dict[str, str]]:
    """Return the table of the errors of nodes, with a row for each correction."""
    fitting = [each for each in measured if each.recording.name in FITTED]
    sizes = ", ".join(str(size) for size in sorted({each.size for each in fitting}))
    others = [each for each in measured if each.recording.name not in FITTED]
    pairs = Pairs.mean([each.pairs() for each in fitting])
    moved, turned = pairs.translation(), pairs.displacement()

    def of_height(height: float) -> Pairs:
        return Pairs.mean([each.pairs(height) for each in fitting])

    def left(height: float) -> float:
        return of_height(height).distance(of_height(height).displacement())

    height = float(minimize_scalar(left, bounds=(SHORTEST, 2.0 - SHORTEST), method="bounded").x)
    smaller = of_height(height).displacement()
    each_grid, of_grid = by_grid(fitting)
    return [
        row("as it is", "nothing", unmoved, others),
        row("the camera moved", f"on six: {moved}", displaced(moved), others),
        row("moved and turned", f"on six: {turned}", displaced(turned), others),
        row(f"moved and turned, grids of {sizes}", f"on those of the six: {each_grid}", of_grid, others),
        row(
            "moved, turned, another height",
            f"on six: {smaller}, height {height:.3f}",
            displaced(smaller, height),
            others,
        ),
        row("moved and turned", "on each recording itself", by_itself, others),
        row("without the mean of each node", "on each recording itself", per_node, others),
        row("later or earlier", "on each recording itself", later, others),
        row("without the mean of each frame", "on each frame itself", per_frame, others),
    ]


def narrower(measured: list[Seen]) -> str:
    """Return a sentence that tells how much narrower the lower edge of the cloth is than the held edge.

    The sentence has two values: the value that the camera saw, and the predicted value.
    """
    others = [each for each in measured if each.recording.name not in FITTED]
    seen, predicted = (1e3 * np.median([_narrower(nodes) for nodes in group]) for group in _both(others))
    return f"The lower edge is seen {seen:.0f} mm narrower than the bar; predicted are {predicted:.0f} mm."


def _both(measured: list[Seen]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    return [each.seen for each in measured], [each.predicted for each in measured]


def _narrower(nodes: np.ndarray) -> float:
    """Return how much narrower the lower edge of the cloth is than the held edge, as a median over frames [m]."""
    width = np.linalg.norm(nodes[:, :, -1] - nodes[:, :, 0], axis=2)
    return float(np.nanmedian(width[:, -1] - width[:, 0]))


def main() -> None:
    """Parse the command line, and print the table of errors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    recordings = load_recordings(options.data / FILE, SESSION, LEFT_OUT)
    fitting = [recording for recording in recordings if recording.name in FITTED]
    bench = Bench(SIMULATOR, options.out / "kept" / "motion")
    air = fit(lambda law: swings_in(law, fitting, bench), fitting, turning, START_TURNING)
    measured = [Seen(each, simulate(Sheet(each).scene(air), SIMULATOR)) for each in recordings]
    text = f"{markdown(table(measured))}\n\n{narrower(measured)}"
    print(text)


if __name__ == "__main__":
    main()
