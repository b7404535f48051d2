"""Trials and fixed trajectories, as `result.json` and the study have them (docs/reference/result-folder.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from tatamu.base.records import OpenRecord
from tatamu.evaluation.evaluator import Evaluation
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import MEASURES, Score
from tatamu.search import Parameters, Proposal
from tatamu.simulation.scene import Index, Points

OWN_VALUES = ("objective", "trajectory_length")
"""Measures that exist even if a trial failed."""


class Scored(OpenRecord):
    """Base of trials and fixed trajectories. In files, each measure of the score is a field of its own."""

    objective: float | None = None
    """Objective C = l_x + alpha D of Eq. (10) without disturbances, or a penalty if the fold failed."""
    trajectory_length: float | None = None
    """Trajectory length l_x of Eq. (10) [m]."""
    score: Score | None = None
    """None if the fold failed."""

    @model_validator(mode="before")
    @classmethod
    def _gather(cls, value: Any) -> Any:
        if not isinstance(value, dict) or "score" in value or value.get("state") == "failed":
            return value
        measures = {name: value[name] for name in MEASURES if value.get(name) is not None}
        others = {name: each for name, each in value.items() if name not in MEASURES or name in OWN_VALUES}
        return {**others, "score": measures}

    @model_serializer(mode="wrap")
    def _plain(self, standard: SerializerFunctionWrapHandler) -> dict[str, Any]:
        plain = OpenRecord._plain(self, standard)
        measures = dict.fromkeys(MEASURES) if self.score is None else self.score.model_dump()
        own = {name: plain.get(name) for name in OWN_VALUES}
        plain.pop("score", None)
        return {**plain, **measures, **own}


def _found(found: Evaluation) -> dict[str, Any]:
    """Return the fields that trials and fixed trajectories have of an evaluation."""
    return {
        "state": "failed" if found.failed else "complete",
        "error": found.error,
        "objective": found.nominal,
        "trajectory_length": found.trajectory_length,
        "score": found.score,
        "seconds": round(found.seconds, 3),
    }


class ScenarioCount(OpenRecord):
    """In how many scenarios a trial was simulated, and how many of them it passes."""

    simulated: int
    succeeded: int


class Trial(Scored):
    """One evaluation of a study, as `result.json` has it."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"expected_gain", "scenarios", "value"})
    FORMER: ClassVar[Mapping[str, str]] = {"expected_objective": "value"}

    number: Index
    state: Literal["complete", "failed"]
    error: str | None = None
    parameters: Parameters
    seconds: float | None = None
    """Wall time [s]."""
    expected_gain: float | None = None
    """Improvement that the search expected, as a fraction of the best objective; None if it made no estimate."""
    scenarios: ScenarioCount | None = None
    value: float | None = None
    """What the search minimises; None if it is C of Eq. (10), the field `objective`."""
    failed_in: list[Index] = Field(default_factory=list, exclude=True)
    """Indices of the scenarios that the fold does not pass. Only the database has them."""

    @property
    def minimised(self) -> float:
        value = self.objective if self.value is None else self.value
        assert value is not None, "a trial has an objective"
        return value

    @classmethod
    def of(cls, number: int, proposal: Proposal, found: Evaluation) -> Self:
        tried = ScenarioCount(simulated=found.scenarios, succeeded=found.scenarios - len(found.failed_in))
        return cls(
            **_found(found),
            number=number,
            parameters=dict(proposal),
            expected_gain=proposal.gain,
            scenarios=tried if found.scenarios else None,
            value=None if found.objective == found.nominal else found.objective,
            failed_in=list(found.failed_in),
        )

    @property
    def proposal(self) -> Proposal:
        """The trial as the search proposed it."""
        return Proposal(self.parameters, self.expected_gain)

    def attributes(self) -> dict[str, Any]:
        """Return what a study stores beside the parameters and the value.

        The number is included, because a storage may lose trials and renumber the others.
        """
        plain = self.model_dump(exclude={"parameters"})
        if self.value is None:
            plain.pop("objective")
        return {**plain, "failed_in": self.failed_in} if self.failed_in else plain


class Baseline(Scored):
    """A fixed trajectory for comparison."""

    name: str
    title: str = ""
    state: Literal["complete", "failed"] = "complete"
    error: str | None = None
    seconds: float | None = None
    """Wall time [s]."""
    path: Points
    """Path of the left hand relative to its grasp [m], shape (k, 3)."""

    @property
    def label(self) -> str:
        """Name for pages and tables."""
        return self.title or self.name

    @classmethod
    def of(cls, name: str, manipulation: Manipulation, found: Evaluation) -> Self:
        path = manipulation.paths[0]
        return cls(**_found(found), name=name, title=BASELINES[name][0], path=path[:: max(1, len(path) // 100)])
