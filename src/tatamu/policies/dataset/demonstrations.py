"""Writes the episodes of a dataset as demonstrations in LeRobot's format."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np

from tatamu.folding.manipulation import HANDS
from tatamu.lerobot import Feature, LeRobotWriter, camera, flag, vector
from tatamu.policies.dataset.arms import Stand
from tatamu.policies.dataset.episode import Episode
from tatamu.policies.dataset.record import columns_of
from tatamu.policies.dataset.specification import DatasetSpecification
from tatamu.robots import load
from tatamu.robots.model import state_names

FLOATING = "tatamu_hands"
"""LeRobot's type of robot for floating hands."""


@contextmanager
def writing_demonstrations(
    root: Path, specification: DatasetSpecification, stand: Stand | None, first: Episode, key_points: int | None
) -> Iterator[Callable[[Episode], None]]:
    """Yield a function that appends an episode to the LeRobotDataset, which is complete after the `with` statement.

    Args:
        root: Folder of the LeRobotDataset, in which other files may be.
        specification: The specification of the dataset.
        stand: The robot, and the placement of the fold; None for floating hands.
        first: Any episode, for the sizes of the arrays.
        key_points: Number of key points of every garment; None if the numbers differ.

    Raises:
        InputError: If a package or an encoder is missing, or the folder cannot be written.
    """
    if stand is None:
        hands = HANDS[: first.arrays["hands"].shape[1] // 4]
        states = [f"{hand}_{axis}" for hand in hands for axis in ("x.pos", "y.pos", "z.pos", "gripper.pos")]
        actions = [f"{hand}_{axis}" for hand in hands for axis in ("x.move", "y.move", "z.move", "gripper.close")]
    else:
        states = actions = [*state_names(load(stand.robot))]
    features: dict[str, Feature] = {"observation.state": vector(states), "action": vector(actions)}
    if key_points is not None:
        names = [f"key_point_{number}.{axis}" for number in range(key_points) for axis in "xyz"]
        features["observation.environment_state"] = vector(names)
    features |= {f"observation.images.{name}": camera(specification.record.pixels) for name in specification.cameras}
    features |= {"next.reward": Feature("float32", (1,)), "next.done": flag(), "next.success": flag()}
    robot = FLOATING if stand is None else stand.robot
    with LeRobotWriter(root / "lerobot", specification.record.fps, features, robot) as writer:
        yield partial(_add, writer)
    for part in writer.root.iterdir():
        part.rename(root / part.name)
    writer.root.rmdir()


def _add(writer: LeRobotWriter, episode: Episode) -> None:
    """Append an episode. Each observation is stored with the action and the reward that follow it."""
    arrays = episode.arrays
    frames = len(arrays["action"])
    last = np.arange(frames)[:, None] == frames - 1
    values: dict[str, np.ndarray] = {
        "observation.state": arrays["state"][:-1],
        "action": arrays["action"],
        "next.reward": arrays["reward"][:, None],
        "next.done": last,
        "next.success": last & episode.record.success,
    }
    if "observation.environment_state" in writer.features:
        values["observation.environment_state"] = arrays["key_points"][:-1].reshape(frames, -1)
    for name, pictures in arrays.items():
        if name.startswith("camera."):
            values[f"observation.images.{name.removeprefix('camera.')}"] = pictures[:-1]
    columns = columns_of(episode.record)
    writer.add_episode(values, columns.pop("task"), columns)
