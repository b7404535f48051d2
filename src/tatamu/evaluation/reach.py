"""An evaluator that only allows manipulations within a robot's reach.

A manipulation out of reach fails without a simulation. Its objective grows with the distance by which it is out of
reach.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace

from tatamu.evaluation.evaluator import NOTHING, Evaluation, Incumbent, Wrapper
from tatamu.folding.task import Reach


@dataclass(frozen=True)
class WithinReach(Wrapper):
    """Evaluator that refuses manipulations out of a robot's reach.

    A robot places its arms for a manipulation, and reuses these placements for later manipulations. Therefore reach is
    checked in the order of the trials, in the process that proposes them.
    """

    reach: Reach

    @property
    def contains_length(self) -> bool:
        """Whether the trajectory length l_x of Eq. (10) is a part of the objective."""
        return self.inner.contains_length

    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation. It is not simulated if it is out of reach."""
        return self.refuse(parameters) or self.inner(parameters, beat)

    def refuse(self, parameters: Mapping[str, int | float]) -> Evaluation | None:
        """Return a failed evaluation if the robot cannot execute the manipulation; otherwise None."""
        short = -self.reach.quality(self.task.manipulation(parameters))
        if short <= 0.0:
            return self.inner.refuse(parameters)
        failed = self.inner.fail(parameters, f"out of reach of {self.reach.robot}")
        objective = failed.objective + short
        return replace(failed, objective=objective, nominal=objective, simulations=0)

    def submit(
        self, executor: Executor, parameters: Mapping[str, int | float], beat: Incumbent, *, keep: bool = False
    ) -> Future[Evaluation]:
        """Submit an evaluation to an executor. Reach is checked in this process, so workers do not need the robot."""
        refused = self.refuse(parameters)
        if refused is None:
            return self.inner.submit(executor, parameters, beat, keep=keep)
        answer: Future[Evaluation] = Future()
        answer.set_result(refused)
        return answer
