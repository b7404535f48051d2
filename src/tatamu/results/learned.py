"""A learned fold: everything that its folder holds, read and checked against one another."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.errors import InputError
from tatamu.folding.score import vertex_distances
from tatamu.results.folder import ResultFolder
from tatamu.results.manipulation import ArmPath, ManipulationDescription
from tatamu.results.result import Result
from tatamu.rollout import Rollout
from tatamu.scene import Gripper, Scene
from tatamu.topology import facing_down

MOMENTS = {
    "error_first": (1, "First trial"),
    "error_10": (10, "Best after 10"),
    "error_50": (50, "Best after 50"),
}
"""Optional arrays of rollout.npz with e_i [m], shape (n,): after how many trials, and their titles."""


@dataclass(frozen=True)
class LearnedFold:
    """The best manipulation of a study, the search that found it, and the motion of the cloth."""

    folder: Path
    result: Result
    manipulation: ManipulationDescription
    scene: Scene
    rollout: Rollout

    @property
    def start(self) -> np.ndarray:
        """The cloth before the fold [m], shape (n, 3)."""
        return self.rollout.positions[0]

    @property
    def final(self) -> np.ndarray:
        """The cloth after the fold [m], shape (n, 3)."""
        return self.rollout.positions[-1]

    @property
    def target(self) -> np.ndarray:
        """The wanted shape [m], shape (n, 3)."""
        return self.rollout.extra["target"]

    @property
    def faces(self) -> np.ndarray:
        """Triangles, shape (m, 3)."""
        return self.rollout.faces

    @property
    def lower(self) -> np.ndarray:
        """Which triangles are of the lower layer, shape (m,): the back of a garment of two layers."""
        return facing_down(self.scene.cloth.rest, self.faces)

    @property
    def errors(self) -> np.ndarray:
        """e_i of the learned fold, Eq. (12) [m], shape (n,)."""
        return vertex_distances(self.target, self.final)

    @property
    def moments(self) -> list[tuple[str, np.ndarray]]:
        """e_i [m] along the search: title and shape (n,); ends with the learned fold."""
        known = {name: moment for name, moment in MOMENTS.items() if name in self.rollout.extra}
        titled = [(title, self.rollout.extra[name]) for name, (_, title) in known.items()]
        count = len(self.result.trials)
        ended = count in [after for after, _ in known.values()]
        return titled if ended else [*titled, (f"Best of all {count}", self.errors)]

    def hand(self, arm: ArmPath) -> np.ndarray:
        """Positions of a hand at each frame [m], shape (f, 3)."""
        return np.array(arm.grasp.position) + self._gripper(arm).path(self.rollout.times)

    def _gripper(self, arm: ArmPath) -> Gripper:
        """The gripper that follows the hand: the first of those that hold its patch."""
        patch = {arm.grasp.vertex, *arm.grasp.patch}
        holding = [gripper for gripper in self.scene.grippers if not patch.isdisjoint(gripper.vertices)]
        if not any(arm.grasp.vertex in gripper.vertices for gripper in holding):
            raise InputError(
                f"{self.folder / 'scene.json'}: grippers: none holds vertex {arm.grasp.vertex}, "
                f"the grasp of the {arm.name} arm in manipulation.json"
            )
        return holding[0]


def read_fold(path: Path) -> LearnedFold:
    """Read the folder of a learned fold.

    Raises:
        InputError: A file is missing, broken, of another version or does not fit the others.
    """
    folder = ResultFolder(path)
    if folder.result.best is None:
        raise InputError(f"{path}: all of its trials failed; there is no learned fold in it")
    fold = LearnedFold(path, folder.result, folder.manipulation, folder.scene, folder.rollout)
    _check_arrays(folder)
    _check_order(folder)
    return fold


def _check_arrays(folder: ResultFolder) -> None:
    """Refuse a rollout whose arrays do not fit the scene."""
    rollout = folder.rollout
    frames = len(rollout.times)
    count = len(folder.scene.cloth.vertices)
    arrays = {"positions": rollout.positions, "target": folder.target}
    arrays |= {name: rollout.extra[name] for name in MOMENTS if name in rollout.extra}
    shapes = {"positions": (frames, count, 3), "target": (count, 3)}
    for name, array in arrays.items():
        shape = shapes.get(name, (count,))
        if array.shape != shape or not frames:
            raise InputError(
                f"{folder.rollout_file}: {name} must have shape {shape} as scene.json has, given {array.shape}"
            )
        if array.dtype.kind != "f" or not np.isfinite(array).all():
            raise InputError(f"{folder.rollout_file}: {name} must be finite numbers in metres")


def _check_order(folder: ResultFolder) -> None:
    """Refuse times that do not increase, and faces of vertices that are not there."""
    times = folder.rollout.times
    faces = folder.rollout.faces
    count = len(folder.scene.cloth.vertices)
    if times.ndim != 1 or not (np.diff(times) > 0).all() or not np.isfinite(times).all():
        raise InputError(f"{folder.rollout_file}: times must increase from frame to frame")
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu" or not len(faces):
        raise InputError(f"{folder.rollout_file}: faces must be whole numbers of shape (m, 3), given {faces.shape}")
    if faces.min() < 0 or faces.max() >= count:
        raise InputError(f"{folder.rollout_file}: faces must use vertices 0 to {count - 1}")
