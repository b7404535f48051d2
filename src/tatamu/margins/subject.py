"""The fold whose margins are measured: its task, its manipulation and the meshes that it is simulated on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tatamu import curves
from tatamu.disturbances import FoldOnMesh, fold_on_coarser_mesh
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation
from tatamu.results import ManipulationDescription, RebuiltFold, rebuild


def subject_of(folder: Path, simulator: str | None = None) -> tuple[RebuiltFold, FoldOnMesh]:
    """The learned fold in a folder on its own mesh, in the simulator of that name; None: where it was learned.

    Raises:
        InputError: The folder holds no learned fold that can be built again.
    """
    learned = rebuild(folder)
    task = replace(learned.task, reach=None, simulator=simulator or learned.task.simulator)
    return learned, FoldOnMesh(task, _manipulation(learned.fold.manipulation, task.fold))


def _manipulation(description: ManipulationDescription, fold: Fold) -> Manipulation:
    """The manipulation that `manipulation.json` describes, to the last digit that it has."""
    grasps = tuple(arm.grasp.vertex for arm in description.arms)
    places = tuple(fold.start[vertex] for vertex in grasps)
    points = tuple(np.asarray(arm.control_points) - arm.control_points[0] for arm in description.arms)
    lift = float(description.arms[0].control_points[0][2]) - description.arms[0].grasp.position[2]
    return Manipulation(grasps, places, tuple(map(curves.sampled_bezier, points)), points, max(0.0, lift))


def coarse(learned: RebuiltFold, subject: FoldOnMesh) -> FoldOnMesh | None:
    """The subject on a coarser mesh; None where there is none."""
    parameters = learned.fold.result.best_trial.parameters
    return fold_on_coarser_mesh(learned.with_coarser_mesh(), subject.manipulation, parameters)
