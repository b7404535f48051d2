"""Trials and fixed trajectories in `result.json` and in the study. See docs/reference/result-folder.md."""

from __future__ import annotations

from base64 import b64decode, b64encode
from typing import Any, ClassVar, Literal, Self
from zlib import compress, decompress

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from tatamu.evaluation import Evaluation
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import MEASURES, Score
from tatamu.records import OpenRecord
from tatamu.scene import Index, Points
from tatamu.search import HIGH, LOW, Parameters, Proposal

OWN_VALUES = ("objective", "trajectory_length")
"""Measures that a failed trial has as well."""


class Scored(OpenRecord):
    """Base of records that have the measures of a fold among their own fields."""

    objective: float | None = None
    """C = l_x + alpha D of Eq. (10) without disturbances, or a penalty if the fold failed."""
    trajectory_length: float | None = None
    """l_x of Eq. (10) [m]."""
    score: Score | None = None
    """All measures; None if the fold failed."""

    @model_validator(mode="before")
    @classmethod
    def _gather(cls, value: Any) -> Any:
        """Make the score of the measures of a file."""
        if not isinstance(value, dict) or "score" in value or value.get("state") == "failed":
            return value
        measures = {name: value[name] for name in MEASURES if value.get(name) is not None}
        others = {name: each for name, each in value.items() if name not in MEASURES or name in OWN_VALUES}
        return {**others, "score": measures}

    @model_serializer(mode="wrap")
    def _plain(self, standard: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Put the measures of the score among the other fields; None if there is no score."""
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
    """Why the trial failed."""
    parameters: Parameters
    seconds: float | None = None
    """Wall time [s]."""
    spacing: float | None = None
    """Spacing of the mesh that it ran on [m]; None for the task's. D on a coarser mesh is multiplied by the ratio of
    the numbers of vertices."""
    ended: Literal["arrival"] | None = None
    """"arrival" if it ended when the hands arrived, because it could not become the best; None if it ran to its end."""
    expected_gain: float | None = None
    """Expected improvement, as a fraction of the best objective; None if the search did not estimate it."""
    worlds: int | None = None
    """Number of simulated worlds, the nominal one included; None without disturbances."""
    expected_objective: float | None = None
    """The minimised value, or a bound of it if the trial was stopped early because it could not become the best.

    None if `objective` is minimised. If disturbances are given, it is C for a fold that holds in most worlds, and more
    for other folds; or it is the mean over the worlds. If the user gave an evaluator, it is the value of that
    evaluator.
    """
    hardest: list[Index] = Field(default_factory=list, exclude=True)
    """Numbers of the disturbed worlds in which the trial was simulated, hardest first. A disturbed world is one random
    draw of the disturbances. The list is empty if the trial was stopped early because it could not become the best."""
    packed_errors: str | None = Field(None, exclude=True)
    """e_i of Eq. (12), packed; None if the search does not need them."""

    @property
    def minimised(self) -> float:
        """The value that the search minimised."""
        value = self.objective if self.expected_objective is None else self.expected_objective
        assert value is not None, "a trial has an objective"
        return value

    @classmethod
    def of(cls, number: int, proposal: Proposal, found: Evaluation, *, disturbed: bool, spacing: float | None) -> Self:
        """Return the record of an evaluation.

        Args:
            number: Number of the trial.
            proposal: Its parameters.
            found: The evaluation.
            disturbed: Whether the objective is taken over disturbed worlds.
            spacing: Spacing of the mesh that it ran on [m]; None in studies with one mesh.
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
            packed_errors=None if found.errors is None or found.failed else _pack(found.errors),
        )

    def proposal(self, coarse: float | None) -> Proposal:
        """Return the proposal of the trial; `coarse` is the spacing of the coarser mesh [m], if the study has one."""
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
            fidelity=self.proposal(coarse).fidelity,
            ended=self.ended,
            seconds=self.seconds or 0.0,
            errors=None if self.packed_errors is None else _unpack(self.packed_errors),
        )

    def attributes(self) -> dict[str, Any]:
        """Return the data of the trial that a study keeps in addition to parameters and the minimised value.

        Its number is among them, because a storage may lose trials and renumber the others.
        """
        plain = self.model_dump(exclude={"parameters"})
        if self.expected_objective is None:
            plain.pop("objective")
        more = {"hardest": self.hardest or None, "packed_errors": self.packed_errors}
        return {**plain, **{name: value for name, value in more.items() if value is not None}}


class Baseline(Scored):
    """A fixed trajectory, folded and measured as the trials were."""

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
        """The name that people read."""
        return self.title or self.name

    @classmethod
    def of(cls, name: str, manipulation: Manipulation, found: Evaluation) -> Self:
        """Return the record of a fixed trajectory, by its name."""
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
    """Return errors e_i [m], shape (n,), as text, to single precision."""
    return b64encode(compress(errors.astype("<f4").tobytes())).decode()


def _unpack(text: str) -> np.ndarray:
    """Return the errors e_i [m] of a text of `_pack`, shape (n,)."""
    return np.frombuffer(decompress(b64decode(text)), "<f4").astype(float)
