"""One timed rollout in a process of its own: it may be given up after a limit, its memory is its own, and it is kept.

python benchmarks/timed_rollouts.py ENGINE KIND FABRIC SPACING OUT.npz
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from benchmarks.engines import run
from benchmarks.timed_folds import FABRICS, FOLDED, SIZE, Fold, shirt, towel
from tatamu.base.errors import TatamuError
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.simulators import SIMULATORS


@dataclass(frozen=True)
class Case:
    """A fold in a simulator."""

    engine: str
    kind: str
    """Kind of garment: towel or T-shirt."""
    fabric: str
    """Fabric of the towel: a key of FABRICS."""
    spacing: float
    """Spacing of the mesh [m]."""

    @property
    def fold(self) -> Fold:
        """Return the scene, and the places where its vertices should end."""
        return towel(self.spacing, FABRICS[self.fabric]) if self.kind == "towel" else shirt(self.spacing)

    def file(self, turn: int) -> str:
        """Return the file name of run number `turn`."""
        words = (self.engine, self.kind, self.fabric.split(",")[0], f"{1e3 * self.spacing:g}mm", str(turn))
        return "-".join(word.replace(" ", "-") for word in words) + ".npz"


@dataclass(frozen=True)
class Timing:
    """Result of a run. With a `note` it failed, and nothing else means anything."""

    vertices: int
    seconds: float
    """Time of the simulation alone, without compiling and starting [s]."""
    peak: float
    """Memory of the process [MB]."""
    shape: np.ndarray
    """Final places of a fixed grid of material points of a towel [m], shape (k, 3), by which meshes are compared."""
    note: str


def timed(case: Case, turn: int, folder: Path, limit: float) -> Timing:
    """The turn-th run of a case: read where it is kept, else run. After `limit` seconds it is given up."""
    out = folder / case.file(turn)
    if not out.exists():
        folder.mkdir(parents=True, exist_ok=True)
        said = _call([case.engine, case.kind, case.fabric, str(case.spacing), str(out)], limit)
        if said is not None:
            keep(out, Timing(0, 0.0, 0.0, np.empty((0, 3)), said))
        timing = kept(out)
        print(f"{out.name}: {timing.note or f'{timing.seconds:.3g} s'}", file=sys.stderr, flush=True)
        return timing
    return kept(out)


def _call(arguments: Sequence[str], limit: float) -> str | None:
    """Run this module; what went wrong, if anything. Processes that it started end with it."""
    command = [sys.executable, "-m", "benchmarks.timed_rollouts", *arguments]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        try:
            _, said = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return f"given up after {limit:g} s"
    return (said.strip().splitlines() or ["ended"])[-1] if process.returncode else None


def kept(file: Path) -> Timing:
    """Read a file that `keep` wrote."""
    with np.load(file) as data:
        vertices, seconds, peak = int(data["vertices"]), float(data["seconds"]), float(data["peak"])
        return Timing(vertices, seconds, peak, data["shape"], str(data["note"]))


def keep(file: Path, timing: Timing) -> None:
    """Write a timing."""
    unfinished = file.with_suffix(".part.npz")
    np.savez(unfinished, **vars(timing))
    unfinished.rename(file)


def measure(case: Case) -> Timing:
    """Run a case in this process."""
    fold = case.fold
    try:
        if case.engine in SIMULATORS:  # load what is compiled, start what is started; Newton's worker does so itself
            run(case.engine, fold.scene.model_copy(update={"duration": 0.05}))
        rollout = run(case.engine, fold.scene)
        check_folded(fold, rollout)
    except TatamuError as error:
        return Timing(0, 0.0, 0.0, np.empty((0, 3)), str(error))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    shape = shape_of(fold, rollout) if case.kind == "towel" else np.empty((0, 3))
    return Timing(len(fold.target), float(rollout.info["wall_seconds"]), peak, shape, "")


def check_folded(fold: Fold, rollout: Rollout) -> None:
    """Refuse a rollout whose time counts for nothing.

    Raises:
        TatamuError: It did not fold.
    """
    distance = fold.distance(rollout)
    if not distance <= FOLDED:
        raise TatamuError(f"did not fold: {1e3 * distance:.0f} mm from the target, {1e3 * FOLDED:g} mm are allowed")


def shape_of(fold: Fold, rollout: Rollout) -> np.ndarray:
    """Return the final places of the material points of a grid [m], shape (k, 3)."""
    width, length = SIZE
    x, y = np.meshgrid(np.linspace(-0.499, 0.499, 81) * length, np.linspace(-0.499, 0.499, 35) * width)
    flat = fold.scene.cloth.rest[:, :2]
    return np.asarray(LinearNDInterpolator(flat, rollout.positions[-1])(x.ravel(), y.ravel()))


if __name__ == "__main__":
    engine, kind, fabric, spacing, out = sys.argv[1:]
    keep(Path(out), measure(Case(engine, kind, fabric, float(spacing))))
