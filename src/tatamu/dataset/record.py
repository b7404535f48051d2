"""The record of an episode: its fold, its disturbances, and the score of its outcome."""

from __future__ import annotations

from collections.abc import Sequence

from tatamu.dataset.subject import Subject
from tatamu.disturbances import World
from tatamu.folding.score import Score
from tatamu.robustness.record import interval_of


class EpisodeRecord(Subject):
    """One episode, with all that is needed to run its actions again."""

    episode: int
    """Number of the episode, from 0."""
    fold: int
    """Number of the fold, which several episodes may share."""
    task: str
    """The task in words."""
    source: str
    """"drawn", or the folder of the learned fold."""
    parameters: dict[str, float]
    """x1, z1, x2, z2 [m], g1 and g2 of Eq. (9)."""
    world: dict[str, float]
    """The value of each disturbance."""
    frames: int
    """Number of actions."""
    vertices: int
    """Number of vertices of the cloth."""
    success: bool
    """Whether the fold succeeds as `Score` defines it."""
    error: str = ""
    """Why the simulation failed; empty if it did not."""
    score: Score | None
    """All measures of the outcome; None if the simulation failed."""
    held_draws: int = 0
    """Number of worlds from which the share is taken."""
    held: int = 0
    """Number of these worlds in which the fold succeeded."""
    held_from: str = ""
    """Source of the worlds: "worlds" of the specification, "margins" or "study" of a learned fold, or "episodes"."""
    held_share: float | None = None
    """Share of disturbed worlds in which this fold succeeds; None without disturbances."""
    held_interval: tuple[float, float] | None = None
    """Confidence interval of the share at 95 % (Clopper and Pearson 1934)."""
    second_simulator: str = ""
    """Name of the second simulator; empty if there is none."""
    second_success: bool | None = None
    """Whether the fold succeeds there; None if there is no second simulator."""
    second_mean_vertex_distance: float | None = None
    """Mean vertex distance to the target there [m]; None without a second simulator, or if it failed."""

    def with_share(self, held: int, draws: int, source: str) -> EpisodeRecord:
        """Return the record with the share of worlds in which the fold succeeds."""
        low, high = interval_of(held, draws)
        share = {"held_share": held / draws, "held_interval": (low, high)}
        return self.model_copy(update={"held": held, "held_draws": draws, "held_from": source, **share})

    @property
    def drawn_world(self) -> World:
        """The world of the episode."""
        return World(self.world)


def with_shares(records: Sequence[EpisodeRecord], disturbed: bool) -> list[EpisodeRecord]:
    """Return the records with the held share of each fold, in the requested worlds or in the fold's episodes.

    Args:
        records: All episodes.
        disturbed: Whether episodes are in disturbed worlds.
    """
    folds: dict[int, list[EpisodeRecord]] = {}
    for record in records:
        folds.setdefault(record.fold, []).append(record)

    def shared(record: EpisodeRecord) -> EpisodeRecord:
        siblings = folds[record.fold]
        known = next((each for each in siblings if each.held_draws), None)
        if known is not None:
            return record.with_share(known.held, known.held_draws, known.held_from)
        if not disturbed:
            return record
        return record.with_share(sum(each.success for each in siblings), len(siblings), "episodes")

    return [shared(record) for record in records]
