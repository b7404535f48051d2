"""A fold that is measured by a photograph, and the photograph with what was inferred drawn over it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path

import numpy as np
from PIL import Image

from tatamu.after.feedback.measured import MeasuredFold, from_numbers
from tatamu.after.feedback.observe import Feedback
from tatamu.base.errors import InputError, SimulationError
from tatamu.base.files import read_bytes
from tatamu.cameras.locate import locate
from tatamu.cameras.pictures import draw_reading
from tatamu.cameras.pose import Pose
from tatamu.cameras.reading import FoldReading, view_fold
from tatamu.cameras.shape import silhouette
from tatamu.evaluation.disturbances import Scenario
from tatamu.evaluation.nominal import Nominal
from tatamu.garments.picture import MAX_PICTURE
from tatamu.study.result import Result


def read_photo(
    learned: Result,
    photo: Path,
    scale: Path | str,
    *,
    before: Path | None = None,
    frame: Pose | None = None,
    lens: Path | None = None,
    corners: Mapping[str, np.ndarray] | None = None,
    failed: bool = False,
    turned_in: Sequence[str] = (),
) -> tuple[MeasuredFold, FoldReading]:
    """Return a measured fold from a photograph, and the reading with its picture.

    Args:
        learned: The learned fold that was carried out.
        photo: Photograph after the fold.
        scale: File of the board in the photograph, or "a4" or "letter" for a sheet of paper. The board must not move
            between both photographs.
        before: Photograph of the cloth before the fold, with the same board; None if `frame` is given.
        frame: Pose of the fold's frame on the board; None if it is found in `before`.
        lens: File of the camera's lens; None if it is not known.
        corners: Pixels of corners by their names, shape (2,). They replace the corners that were found.
        failed: Whether the fold failed.
        turned_in: Corners of the hem that are turned in.

    Raises:
        InputError: If a file or a corner is wrong, or no corner of the hem is visible.
    """
    if (before is None) == (frame is None):
        given = "neither" if before is None else "both"
        raise InputError(f"before, frame: exactly one is needed, given {given}; each tells where the cloth lay")
    place = frame if before is None else locate(before, scale, run=learned, lens=lens)
    assert place is not None, "one of them is given"
    reading = view_fold(photo, scale, place, learned, lens=lens, corners=corners)
    seen = {name: pair for name, pair in reading.values.items() if not name.startswith(tuple(turned_in) or ("-",))}
    source = f"sha256:{sha256(read_bytes(photo, MAX_PICTURE)).hexdigest()}"
    return from_numbers(seen, source=source, failed=failed, turned_in=turned_in), reading


def simulated(found: Feedback, correction: np.ndarray) -> np.ndarray | None:
    """Return the vertices after a fold with the inferred errors and a correction [m]; None if the simulation fails.

    `correction` is a change of the disturbances, shape (k,).
    """
    posterior, subject = found.posterior, found.subject
    values = (posterior.mean + correction).tolist()
    scenario = Scenario(dict(zip(posterior.names, values, strict=True)))
    try:
        rollout = Nominal(subject.task).simulate(subject.parameters, scenario).rollout
    except SimulationError:
        return None
    return None if rollout is None else rollout.positions[-1]


def draw_explained(found: Feedback, reading: FoldReading) -> Image.Image:
    """Return the photograph of the newest fold with the outline that was read and the one with the inferred errors."""
    final = simulated(found, found.folds[found.newest].correction) if found.posterior.used else None
    if final is None:
        return draw_reading(reading)
    faces = found.subject.task.garment.faces
    return draw_reading(reading, np.array(silhouette(reading.pixels_of(final), faces).exterior.coords))
