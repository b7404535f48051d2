"""Defines the records of trials and fixed trajectories, which are stored in `result.json` and in the study.

See docs/reference/result-folder.md.
"""

from __future__ import annotations

from base64 import b64decode, b64encode
from typing import Any, ClassVar, Literal, Self
from zlib import compress, decompress

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from tatamu.base.records import OpenRecord
from tatamu.evaluation import Evaluation
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import MEASURES, Score
from tatamu.search import HIGH, LOW, Parameters, Proposal
from tatamu.simulation.scene import Index, Points

OWN_VALUES = ("objective", "trajectory_length")
"""Names of the measures that exist even if a trial failed."""


class Scored(OpenRecord):
    """Base class of the records of trials and of fixed trajectories.

    In a file, each measure of the fold is a separate field of the record. In memory, the measures are in `score`.
    """

    objective: float | None = None
    """Objective C of Eq. (10) without disturbances, or a penalty if the fold failed.

    C = l_x + alpha D is the length of the hands' path plus the weighted distance of the cloth from its target.
    """
    trajectory_length: float | None = None
    """Trajectory length l_x of Eq. (10) [m]."""
    score: Score | None = None
    """All measures of the fold; None if the fold failed."""

    @model_validator(mode="before")
    @classmethod
    def _gather(cls, value: Any) -> Any:
        """Combine the measures of the fold, which are separate fields in a file, to a score."""
        if not isinstance(value, dict) or "score" in value or value.get("state") == "failed":
            return value
        measures = {name: value[name] for name in MEASURES if value.get(name) is not None}
        others = {name: each for name, each in value.items() if name not in MEASURES or name in OWN_VALUES}
        return {**others, "score": measures}

    @model_serializer(mode="wrap")
    def _plain(self, standard: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Convert the record to plain data for a file, in which each measure of the score is a separate field.

        If there is no score, the measures are None.
        """
        plain = OpenRecord._plain(self, standard)
        measures = dict.fromkeys(MEASURES) if self.score is None else self.score.model_dump()
        own = {name: plain.get(name) for name in OWN_VALUES}
        plain.pop("score", None)
        return {**plain, **measures, **own}


class Trial(Scored):
    """One trial of the study."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"spacing", "ended", "expected_gain", "worlds", "expected_objective"})

    number: Index
    state: Literal["complete", "failed"]
    error: str | None = None
    """Reason why the trial failed; None if the trial is complete."""
    parameters: Parameters
    seconds: float | None = None
    """Wall time of the trial [s]."""
    spacing: float | None = None
    """Spacing of the mesh on which the trial ran [m]; None if the study has only one mesh.

    The shape distance D is a sum over vertices, so it is smaller on a coarse mesh. To make D comparable, D on a coarse
    mesh is multiplied by the ratio of the numbers of vertices, fine to coarse.
    """
    ended: Literal["arrival"] | None = None
    """"arrival" if the trial was stopped when the hands arrived, because it could not become the best.

    None if the trial was not stopped early."""
    expected_gain: float | None = None
    """Improvement that the search expected of the trial, as a fraction of the best objective.

    None if the search does not estimate improvements.
    """
    worlds: int | None = None
    """Number of simulations of the trial, which have different disturbances; None if the study has no disturbances.

    The simulation without disturbances is counted.
    """
    expected_objective: float | None = None
    """The value that the search minimises, if it is not `objective`; None if the search minimises `objective`.

    If the trial was stopped early because it could not improve on the best trial, or only by a little, this field is a
    bound of the value, and at least the value of the best trial.

    With disturbances, the minimised value is a quantile or the mean over simulations with different disturbances. The
    quantile equals the objective C if the fold succeeds in most simulations, and is larger otherwise. If the user gave
    an evaluator, the minimised value comes from this evaluator.
    """
    hardest: list[Index] = Field(default_factory=list, exclude=True)
    """Numbers of the disturbed worlds in which the trial was simulated, hardest first.

    A disturbed world is one random draw of all disturbances. The list is empty if the trial was stopped early because
    it could not become the best."""
    failed_in: list[Index] = Field(default_factory=list, exclude=True)
    """Numbers of the simulated disturbed worlds in which the trial failed, although another fold succeeds there."""
    packed_errors: str | None = Field(None, exclude=True)
    """Vertex distances e_i of Eq. (12) as text; None if the search does not need them."""

    @property
    def minimised(self) -> float:
        """The value of the trial that the search minimised: `expected_objective` or, if it is None, `objective`."""
        value = self.objective if self.expected_objective is None else self.expected_objective
        assert value is not None, "a trial has an objective"
        return value

    @classmethod
    def of(cls, number: int, proposal: Proposal, found: Evaluation, *, disturbed: bool, spacing: float | None) -> Self:
        """Return the record of an evaluation.

        Args:
            number: Number of the trial.
            proposal: Parameters of the trial.
            found: Evaluation of the parameters.
            disturbed: Whether the objective is taken over simulations with random disturbances.
            spacing: Spacing of the mesh on which the trial ran [m]; None if the study has only one mesh.
        """
        other = disturbed or found.objective != found.nominal
        return cls(
            number=number,
            state="failed" if found.failed else "complete",
            error=found.error,
            parameters=proposal.parameters,
            objective=found.nominal,
            trajectory_length=found.trajectory_length,
            score=found.score,
            seconds=round(found.seconds, 3),
            spacing=spacing,
            ended=found.ended,
            expected_gain=proposal.gain,
            worlds=found.simulations if disturbed else None,
            expected_objective=found.objective if other else None,
            hardest=list(found.hardest),
            failed_in=list(found.failed_in),
            packed_errors=None if found.errors is None or found.failed else _pack(found.errors),
        )

    def proposal(self, coarse: float | None) -> Proposal:
        """Return the trial as a proposal of the search.

        The proposal has the parameters, the fidelity (coarse or fine mesh) and the gain that the search expected.
        `coarse` is the spacing of the coarse mesh [m], if the study has one.
        """
        fidelity = LOW if coarse is not None and self.spacing == coarse else HIGH
        return Proposal(self.parameters, fidelity, self.expected_gain)

    def evaluation(self, coarse: float | None) -> Evaluation:
        """Return the evaluation of the trial, without its rollout."""
        assert self.objective is not None and self.trajectory_length is not None, "a trial has an objective"
        return Evaluation(
            parameters=self.parameters,
            trajectory_length=self.trajectory_length,
            objective=self.minimised,
            nominal=self.objective,
            score=self.score,
            error=self.error,
            simulations=self.worlds or 1,
            hardest=tuple(self.hardest),
            failed_in=tuple(self.failed_in),
            fidelity=self.proposal(coarse).fidelity,
            ended=self.ended,
            seconds=self.seconds or 0.0,
            errors=None if self.packed_errors is None else _unpack(self.packed_errors),
        )

    def attributes(self) -> dict[str, Any]:
        """Return the data that a study stores for the trial, in addition to its parameters and the minimised value.

        The number of the trial is included, because a storage may lose trials and renumber the other trials.
        """
        plain = self.model_dump(exclude={"parameters"})
        if self.expected_objective is None:
            plain.pop("objective")
        more = {
            "hardest": self.hardest or None,
            "failed_in": self.failed_in or None,
            "packed_errors": self.packed_errors,
        }
        return {**plain, **{name: value for name, value in more.items() if value is not None}}


class Baseline(Scored):
    """A fixed trajectory for comparison. It is simulated and measured like the trials."""

    name: str
    title: str = ""
    state: Literal["complete", "failed"] = "complete"
    error: str | None = None
    seconds: float | None = None
    """Wall time of the evaluation of the trajectory [s]."""
    path: Points
    """Path of the left hand relative to its grasp, k points [m], shape (k, 3)."""

    @property
    def label(self) -> str:
        """Name of the trajectory as pages and tables show it."""
        return self.title or self.name

    @classmethod
    def of(cls, name: str, manipulation: Manipulation, found: Evaluation) -> Self:
        """Return the record of a fixed trajectory from its name, its manipulation and its evaluation."""
        return cls(
            name=name,
            title=BASELINES[name][0],
            objective=found.nominal,
            trajectory_length=found.trajectory_length,
            score=found.score,
            state="failed" if found.failed else "complete",
            error=found.error,
            seconds=round(found.seconds, 3),
            path=manipulation.paths[0][:: max(1, len(manipulation.paths[0]) // 100)],
        )


def _pack(errors: np.ndarray) -> str:
    """Return the vertex distances e_i [m], shape (n,), as text. They are stored in single precision."""
    return b64encode(compress(errors.astype("<f4").tobytes())).decode()


def _unpack(text: str) -> np.ndarray:
    """Return the vertex distances e_i [m], shape (n,), from a text that `_pack` made."""
    return np.frombuffer(decompress(b64decode(text)), "<f4").astype(float)
