"""Simulates a fold with the errors that were inferred from observed folds, and draws the result over a photograph.

A set-up is one robot with one garment on one table. Its errors are disturbances of the fold, such as errors of the
hands' positions. The posterior is the distribution of these errors after folds were observed.
"""

from __future__ import annotations

import numpy as np
from PIL import Image

from tatamu.after.feedback.observe import Observed
from tatamu.base.errors import SimulationError
from tatamu.cameras.pictures import draw_reading
from tatamu.cameras.reading import FoldReading
from tatamu.cameras.shape import silhouette
from tatamu.evaluation.disturbances import World


def simulated(observed: Observed, correction: np.ndarray) -> np.ndarray | None:
    """Return the positions of the n vertices after a fold with the inferred errors [m], shape (n, 3).

    The result is None if the simulation fails.

    Args:
        observed: The observed folds.
        correction: Correction of the fold, as a change of each of the k disturbances, shape (k,).
    """
    posterior, mesh = observed.posterior, observed.draws.mesh
    values = (posterior.mean + correction).tolist()
    world = World(dict(zip(posterior.names, values, strict=True)))
    try:
        found = mesh.evaluator.in_world(mesh.parameters, world)
    except SimulationError:
        return None
    return None if found.rollout is None else found.rollout.positions[-1]


def draw_explained(observed: Observed, reading: FoldReading) -> Image.Image:
    """Return the photograph of the newest fold with two outlines of the cloth.

    One outline was read from the photograph. The other outline was simulated with the inferred errors.
    """
    final = simulated(observed, observed.folds[observed.newest].correction) if observed.posterior.used else None
    if final is None:
        return draw_reading(reading)
    faces = observed.draws.mesh.evaluator.task.fold.garment.faces
    return draw_reading(reading, np.array(silhouette(reading.pixels_of(final), faces).exterior.coords))
