"""The record of an episode: its fold, its disturbances, and the score of its outcome."""

from __future__ import annotations

from collections.abc import Sequence

from tatamu.evaluation.disturbances import World
from tatamu.evaluation.success import interval_of
from tatamu.folding.score import Score
from tatamu.policies.dataset.subject import Subject


class EpisodeRecord(Subject):
    """The record of one episode, with everything that is needed to run its actions again."""

    episode: int
    """Number of the episode, from 0."""
    fold: int
    """Number of the fold. Several episodes can have the same fold."""
    task: str
    """The task as text."""
    source: str
    """Source of the fold: the word "drawn" for a randomly drawn fold, or the folder of a learned fold."""
    parameters: dict[str, float]
    """Parameters x1, z1, x2, z2 [m], g1 and g2 of the hands' curve, Eq. (9)."""
    world: dict[str, float]
    """Values of the disturbances, by their names. Disturbances with the value 0 are left out."""
    frames: int
    """Number of actions in the episode."""
    vertices: int
    """Number of vertices of the cloth."""
    success: bool
    """Whether the fold succeeds as `Score` defines it."""
    error: str = ""
    """Reason why the simulation failed; empty if it did not fail."""
    score: Score | None
    """All measures of the outcome; None if the simulation failed."""
    held_draws: int = 0
    """Number of disturbed simulations from which `held_share` is computed."""
    held: int = 0
    """Number of disturbed simulations in which the fold succeeded."""
    held_from: str = ""
    """Word that names the source of the disturbed simulations; empty if there are no disturbed simulations.

    The words mean:

    - "worlds": the additional simulations that the specification requests
    - "margins" or "study": the simulations of a learned fold
    - "episodes": the episodes with the same fold
    """
    held_share: float | None = None
    """Success rate of this fold in disturbed simulations, from 0 to 1; None if there are no disturbed simulations."""
    held_interval: tuple[float, float] | None = None
    """Confidence interval of the success rate `held_share` at 95 % (Clopper and Pearson 1934)."""
    second_simulator: str = ""
    """Name of the second simulator; empty if there is no second simulator."""
    second_success: bool | None = None
    """Whether the fold succeeds in the second simulator; None if there is no second simulator."""
    second_mean_vertex_distance: float | None = None
    """Mean vertex distance to the target in the second simulator [m].

    None if there is no second simulator, or if the second simulator failed.
    """

    def with_share(self, held: int, draws: int, source: str) -> EpisodeRecord:
        """Return a copy of the record that contains the success rate of the fold in disturbed simulations."""
        low, high = interval_of(held, draws)
        share = {"held_share": held / draws, "held_interval": (low, high)}
        return self.model_copy(update={"held": held, "held_draws": draws, "held_from": source, **share})

    @property
    def drawn_world(self) -> World:
        """The world of the episode, which has a value of each disturbance."""
        return World(self.world)


def with_shares(records: Sequence[EpisodeRecord], disturbed: bool) -> list[EpisodeRecord]:
    """Return copies of the records that contain the success rate of each fold in disturbed simulations.

    The rate is computed from the additional simulations that the specification requests. If the specification requests
    none, it is computed from the episodes with the same fold, if there are several.

    Args:
        records: Records of all episodes.
        disturbed: Whether the episodes have disturbances.
    """
    folds: dict[int, list[EpisodeRecord]] = {}
    for record in records:
        folds.setdefault(record.fold, []).append(record)

    def shared(record: EpisodeRecord) -> EpisodeRecord:
        siblings = folds[record.fold]
        known = next((each for each in siblings if each.held_draws), None)
        if known is not None:
            return record.with_share(known.held, known.held_draws, known.held_from)
        if not disturbed or len(siblings) == 1:  # one episode would give a rate of 0 or 1
            return record
        return record.with_share(sum(each.success for each in siblings), len(siblings), "episodes")

    return [shared(record) for record in records]
