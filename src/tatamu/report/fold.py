"""A learned fold as its folder holds it, read and checked."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.errors import InputError
from tatamu.files import read_json, validated
from tatamu.results.records import Arm, Manipulation, Result
from tatamu.rollout import Rollout
from tatamu.scene import Gripper, Scene

MOMENTS = {
    "error_first": (1, "First trial"),
    "error_10": (10, "Best after 10"),
    "error_50": (50, "Best after 50"),
}
"""Optional arrays of rollout.npz with e_i [m], shape (n,): after how many trials, and their titles."""


@dataclass(frozen=True)
class LearnedFold:
    """Everything that the report shows."""

    folder: Path
    result: Result
    manipulation: Manipulation
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
    def errors(self) -> np.ndarray:
        """e_i of the learned fold, Eq. (12) [m], shape (n,)."""
        return np.linalg.norm(self.final - self.target, axis=1)

    @property
    def moments(self) -> list[tuple[str, np.ndarray]]:
        """e_i [m] along the search: title and shape (n,); ends with the learned fold."""
        known = {name: moment for name, moment in MOMENTS.items() if name in self.rollout.extra}
        told = [(title, self.rollout.extra[name]) for name, (_, title) in known.items()]
        count = len(self.result.trials)
        ended = count in [after for after, _ in known.values()]
        return told if ended else [*told, (f"Best of all {count}", self.errors)]

    def hand(self, arm: Arm) -> np.ndarray:
        """Where a hand is at each frame [m], shape (f, 3)."""
        return np.array(arm.grasp.position) + self._gripper(arm).path(self.rollout.times)

    def _gripper(self, arm: Arm) -> Gripper:
        for hand in self.scene.hands:
            if any(arm.grasp.vertex in gripper.vertices for gripper in hand):
                return hand[0]
        raise InputError(
            f"{self.folder / 'scene.json'}: grippers: none holds vertex {arm.grasp.vertex}, "
            f"the grasp of the {arm.name} arm in manipulation.json"
        )


def read_fold(folder: Path) -> LearnedFold:
    """Read a result folder.

    Raises:
        InputError: A file is missing, broken, of another version or does not fit the others.
    """
    told = read_json(folder / "result.json")
    if isinstance(told, dict) and "trials" in told and told.get("best", 0) is None:
        raise InputError(f"{folder}: all of its trials failed; there is no learned fold in it")
    result = validated(Result, told, folder / "result.json")
    manipulation = validated(Manipulation, read_json(folder / "manipulation.json"), folder / "manipulation.json")
    scene = Scene.load(folder / "scene.json")
    rollout = Rollout.load(folder / "rollout.npz")
    _check(rollout, len(scene.cloth.vertices), folder / "rollout.npz")
    return LearnedFold(folder, result, manipulation, scene, rollout)


def _check(rollout: Rollout, count: int, path: Path) -> None:
    """Refuse a rollout whose arrays do not fit the scene of `count` vertices."""
    frames = len(rollout.times)
    if "target" not in rollout.extra:
        raise InputError(f"{path}: target is missing, the wanted shape (n, 3) of a learned fold")
    wanted = {"positions": (frames, count, 3), "target": (count, 3)}
    wanted |= {name: (count,) for name in MOMENTS if name in rollout.extra}
    for name, shape in wanted.items():
        array = rollout.positions if name == "positions" else rollout.extra[name]
        if array.shape != shape or not frames:
            raise InputError(f"{path}: {name} must have shape {shape} as scene.json has, given {array.shape}")
        if array.dtype.kind != "f" or not np.isfinite(array).all():
            raise InputError(f"{path}: {name} must be finite numbers in metres")
    _check_order(rollout, count, path)


def _check_order(rollout: Rollout, count: int, path: Path) -> None:
    times, faces = rollout.times, rollout.faces
    if times.ndim != 1 or not (np.diff(times) > 0).all() or not np.isfinite(times).all():
        raise InputError(f"{path}: times must increase from frame to frame")
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu" or not len(faces):
        raise InputError(f"{path}: faces must be whole numbers of shape (m, 3), given {faces.shape}")
    if faces.min() < 0 or faces.max() >= count:
        raise InputError(f"{path}: faces must use vertices 0 to {count - 1}")
