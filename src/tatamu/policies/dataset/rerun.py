"""Run the actions of an episode in the simulator again, and compare the outcome with the recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.score import Score
from tatamu.lerobot import LeRobotReader
from tatamu.policies.dataset.episode import make_env, play
from tatamu.policies.dataset.folder import DatasetFolder
from tatamu.policies.dataset.record import EpisodeRecord, read_outcome
from tatamu.policies.dataset.states import read_states


@dataclass(frozen=True)
class Replay:
    """The outcome of a new simulation of an episode's actions."""

    recorded: EpisodeRecord
    success: bool
    score: Score
    distances: np.ndarray
    """Distances between the new and the recorded final positions [m], shape (n,)."""

    @property
    def differs(self) -> bool:
        """Whether the success or any vertex differs from the recording."""
        return self.success != self.recorded.success or bool(self.distances.any())


def replay(dataset: Path | str, episode: int) -> Replay:
    """Run the actions of an episode in the simulator again.

    Args:
        dataset: Folder of a dataset, whose actions may have been changed.
        episode: Index of the episode.

    Raises:
        InputError: If there is no such dataset or episode, or a file is broken.
    """
    folder = DatasetFolder(Path(dataset))
    about = folder.read()
    recorded, final = read_outcome(folder.table, episode)
    env = make_env(recorded.make_task(), about.specification)
    env.reset(options={"world": recorded.world})
    now = len(env.outcome()[0])
    if not recorded.vertices == len(final) == now:
        given = recorded.vertices if recorded.vertices != now else len(final)
        raise InputError(
            f"{folder.path}: episode {episode} was recorded with {given} vertices, but the garment has {now}"
        )
    actions = _actions(folder, "lerobot" in about.specification.formats, episode)
    answers = play(env, actions, about.stand)
    reached, score = env.outcome()
    success = bool(answers) and bool(answers[-1][4]["is_success"])
    return Replay(recorded, success, score, np.linalg.norm(reached - final, axis=1))


def _actions(folder: DatasetFolder, in_lerobot: bool, episode: int) -> np.ndarray:
    if in_lerobot:
        return LeRobotReader(folder.path).numbers(episode, "action")["action"]
    return read_states(folder.states, episode, ["action"])["action"]
