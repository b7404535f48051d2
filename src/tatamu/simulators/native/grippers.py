"""The grippers of a scene under way: which are closed, what they hold, and where it goes."""

from __future__ import annotations

import numpy as np

from tatamu.scene import Gripper, Scene
from tatamu.simulators.native.system import Hands


class Grippers:
    """Grippers by number, in outer steps rather than seconds."""

    def __init__(self, scene: Scene, outer_step: float, steps: int) -> None:
        """Sample the paths.

        Args:
            scene: The scene.
            outer_step: Length of an outer step [s].
            steps: How many there will be.
        """
        self._grippers = scene.grippers
        self._outer_step = outer_step
        self._latest = 2 * scene.duration
        self._closed: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        times = np.arange(steps + 1) * outer_step
        self._paths = np.zeros((max(len(scene.grippers), 1), len(times), 3))
        for path, gripper in zip(self._paths, scene.grippers, strict=False):
            path[:] = gripper.path(times)

    def step_at(self, time: float) -> int:
        """Number of the outer step at which something at `time` [s] happens."""
        return round(min(time, self._latest) / self._outer_step)

    def events(self) -> list[int]:
        """Numbers of the outer steps at which grippers close or open."""
        times = [time for gripper in self._grippers for time in (gripper.closes, gripper.opens)]
        return [self.step_at(time) for time in times if time is not None]

    def open_due(self, number: int) -> list[np.ndarray]:
        """Open the grippers that do not hold in step `number`; the vertices of each that did until now."""
        due = sorted(self._closed.keys() - self._wanted(number))
        return [self._closed.pop(gripper)[0] for gripper in due]

    def close_due(self, number: int, x: np.ndarray) -> list[np.ndarray]:
        """Close the grippers that hold from step `number` on, at positions x [m]; the vertices of each."""
        due = sorted(self._wanted(number) - self._closed.keys())
        taken = []
        for gripper in due:
            vertices = np.array(self._grippers[gripper].vertices)
            self._closed[gripper] = (vertices, x[vertices].copy())
            taken.append(vertices)
        return taken

    def hands(self) -> Hands:
        """Vertices that are held now, and their paths."""
        if not self._closed:
            return Hands(np.empty(0, np.int64), np.empty((0, 3)), np.empty(0, np.int64), self._paths)
        return Hands(
            vertex=np.concatenate([vertices for vertices, _ in self._closed.values()]),
            base=np.concatenate([base for _, base in self._closed.values()]),
            gripper=np.concatenate([np.full(len(v), number) for number, (v, _) in self._closed.items()]),
            path=self._paths,
        )

    def _wanted(self, number: int) -> set[int]:
        return {i for i, gripper in enumerate(self._grippers) if self._holds(gripper, number)}

    def _holds(self, gripper: Gripper, number: int) -> bool:
        over = gripper.opens is not None and self.step_at(gripper.opens) <= number
        return self.step_at(gripper.closes) <= number and not over
