"""A study: the trials of one task, kept in an Optuna database that survives being killed at any moment.

Only finished trials are written, each in one transaction, so that a killed run leaves nothing half-done behind.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any, ClassVar, NamedTuple

import numpy as np
import optuna
from optuna.distributions import BaseDistribution
from optuna.trial import FrozenTrial, TrialState, create_trial
from pydantic import Field, ValidationError
from threadpoolctl import ThreadpoolController

from tatamu.errors import InputError, UnavailableError
from tatamu.learning.gp_sampler import KnownPart
from tatamu.learning.lm_sampler import ERRORS, packed
from tatamu.learning.place import StudyPlace
from tatamu.learning.refining import Known, refining_proposal
from tatamu.learning.samplers import OVER_ERRORS, make_sampler
from tatamu.learning.trial_rows import write_trial
from tatamu.records import OpenRecord
from tatamu.results.result import Baseline, Parameters, TaskDescription

KEY = "tatamu"
"""User attribute of the study that says which task it belongs to."""
_THREADS = ThreadpoolController()
"""Of linear algebra. One is enough for small matrices: threads that wait for one another cost ten times the work."""
optuna.logging.set_verbosity(optuna.logging.ERROR)


class Identity(OpenRecord):
    """The task of a study and its search: what a study must have begun with in order to be gone on with."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"parallel", "first", "coarse", "disturbances", "quantile", "worlds"})

    task: TaskDescription
    sampler: str
    grasps: str = "integer"
    seed: int
    parallel: int = 1
    """How many trials are pending at a time."""
    first: list[Parameters] = Field(default_factory=list)
    """Parameters of the first trials, where they shall not be the sampler's; with `coarse`, the last of them are of
    the first trial on the task's own mesh."""
    coarse: float | None = None
    """Spacing of the coarser mesh that the search begins on [m]; None: all trials are on the task's own."""
    disturbances: dict[str, Any] | None = None
    """All that is not known; None: the objective is C of Eq. (10), where nothing is off."""
    worlds: int | None = None
    """Disturbed worlds of a trial that may win."""
    quantile: float | None = None
    """The quantile of the objective that is minimised; None: its mean."""


class ProposedTrial(NamedTuple):
    """The next trial."""

    parameters: Parameters
    coarse: bool = False
    """Whether it runs on the coarser mesh."""
    gain: float | None = None
    """Expected improvement, as a part of the best objective that it knows; None: the sampler does not say."""


class OptunaStudy:
    """The finished trials of one task, and the sampler that proposes the next."""

    def __init__(
        self, place: StudyPlace, identity: Identity, space: Mapping[str, BaseDistribution], known_part: KnownPart
    ) -> None:
        """Open the study at a place, or begin one.

        Args:
            place: A database, and the name there.
            identity: Must be the one that the study began with.
            space: Bounds of the search.
            known_part: The part of the objective that is known before a trial runs: l_x of Eq. (10).

        Raises:
            InputError: The file is no such study, or it belongs to another task.
        """
        self.identity = identity
        self.space = dict(space)
        self._known_part = known_part
        self._place = place
        plain = json.loads(json.dumps(identity.model_dump()))
        self._study = place.run(self._opened)
        held = place.run(lambda: self._study.user_attrs.get(KEY))
        if held is None:
            self._begin(plain)
        elif held != plain:
            raise InputError(f"{place.label}: holds another study ({_difference(held, plain)}); give another folder")
        self._trials = place.run(lambda: self._study.get_trials(deepcopy=False))

    def _opened(self) -> optuna.Study:
        return optuna.create_study(
            storage=self._place.storage, study_name=self._place.name, direction="minimize", load_if_exists=True
        )

    def _begin(self, identity: dict[str, Any]) -> None:
        if self._place.run(lambda: self._study.trials):
            raise InputError(f"{self._place.label}: holds a study that is not tatamu's; give another folder")
        self._place.run(lambda: self._study.set_user_attr(KEY, identity))

    @property
    def trials(self) -> list[FrozenTrial]:
        """Finished trials in order; those of the file were read once, as nobody else may write it meanwhile."""
        return self._trials

    def is_coarse(self, trial: FrozenTrial) -> bool:
        """Whether a finished trial ran on the coarser mesh."""
        coarse = self.identity.coarse
        return coarse is not None and bool(trial.user_attrs.get("spacing") == coarse)

    def ask(self, pending: Sequence[ProposedTrial], known: int, coarse: bool = False) -> ProposedTrial:
        """The next trial.

        Args:
            pending: Trials before it that are still running.
            known: How many finished trials it may know the objective of. The others count as running.
            coarse: Whether it runs on the coarser mesh. On the finer one, trials of the coarser one are known too.
        """
        finished = self.trials
        number = len(finished) + len(pending)
        here = [trial for trial in finished[:known] if self.is_coarse(trial) == coarse]
        running = [trial.params for trial in finished[known:] if self.is_coarse(trial) == coarse]
        running += [proposal.parameters for proposal in pending if proposal.coarse == coarse]
        first = self._first(number, coarse, len(here) + len(running))
        if first is not None:
            return ProposedTrial(dict(first), coarse)
        elsewhere = [] if coarse else [trial for trial in finished[:known] if self.is_coarse(trial)]
        if elsewhere:
            return self._refine(number, elsewhere, here, running)
        alone = number == self._begun(coarse)
        return self._propose(number, [] if alone else here, running, coarse)

    def _begun(self, coarse: bool) -> int:
        """The number of the trial after those that the search shall begin with.

        It is random: from low curves alone that all fail alike, a sampler would learn that only the path counts.
        """
        first = len(self.identity.first)
        return max(0, first - 1) if coarse else first

    def _first(self, number: int, coarse: bool, on_this_mesh: int) -> Parameters | None:
        """Parameters that the search shall begin with; on two meshes the last of them begin the trials on the finer."""
        first = self.identity.first
        if self.identity.coarse is None:
            return first[number] if number < len(first) else None
        if coarse:
            return first[number] if number < len(first) - 1 else None
        return first[-1] if first and not on_this_mesh else None

    def _propose(
        self, number: int, known: Sequence[FrozenTrial], running: Sequence[Parameters], coarse: bool
    ) -> ProposedTrial:
        sampler = make_sampler(self.identity.sampler, self.identity.seed, number, self._known_part)
        scratch = optuna.create_study(sampler=sampler, direction="minimize")
        scratch.add_trials(known)
        for parameters in running:
            scratch.add_trial(create_trial(state=TrialState.RUNNING, params=parameters, distributions=self.space))
        with _THREADS.limit(limits=1):
            parameters = dict(scratch.ask(self.space).params)
        return ProposedTrial(parameters, coarse, getattr(sampler, "expected_gain", None))

    def _refine(
        self,
        number: int,
        coarse: Sequence[FrozenTrial],
        fine: Sequence[FrozenTrial],
        running: Sequence[Parameters],
    ) -> ProposedTrial:
        random = np.random.default_rng([self.identity.seed, number])
        with _THREADS.limit(limits=1):
            parameters, gain = refining_proposal(
                self.space, self._known_part, _known(coarse), _known(fine), running, random
            )
        return ProposedTrial(parameters, False, gain)

    @property
    def wants_errors(self) -> bool:
        """Whether the sampler needs the errors e_i of trials beside their objective."""
        return self.identity.sampler in OVER_ERRORS

    def tell(
        self, parameters: Parameters, objective: float, attributes: dict[str, Any], errors: np.ndarray | None = None
    ) -> None:
        """Record a finished trial.

        Args:
            parameters: Of the trial.
            objective: What the study minimises: C of Eq. (10), or its expectation over disturbed worlds.
            attributes: What else is kept.
            errors: e_i of Eq. (12) [m], shape (n,), where the study wants them; None of a failed trial.
        """
        trial = create_trial(
            state=TrialState.COMPLETE,
            value=objective,
            params=parameters,
            distributions=self.space,
            user_attrs=attributes,
            system_attrs={} if errors is None else {ERRORS: packed(errors)},
        )
        trial.datetime_start = trial.datetime_complete = datetime.now()
        trial.number = len(self._trials)
        self._place.run(lambda: self._add(trial), self._is_added)
        self._trials.append(trial)

    def _add(self, trial: FrozenTrial) -> bool:
        self._place.expect_writes()
        storage = self._place.storage
        write_trial(storage, storage.get_study_id_from_name(self._place.name), trial)
        return True

    def _is_added(self) -> bool | None:
        """Whether the database has a trial more than is known here: its answer was lost, not the trial."""
        return len(self._study.get_trials(deepcopy=False)) > len(self._trials) or None

    @property
    def baselines(self) -> list[Baseline] | None:
        """Scores of the fixed trajectories, once they are known."""
        held = self._place.run(lambda: self._study.user_attrs.get("baselines"))
        return None if held is None else [Baseline.model_validate(baseline) for baseline in held]

    @baselines.setter
    def baselines(self, value: Sequence[Baseline]) -> None:
        plain = [baseline.model_dump() for baseline in value]
        self._place.run(lambda: self._study.set_user_attr("baselines", plain))


def _known(trials: Sequence[FrozenTrial]) -> Known:
    return Known([trial.params for trial in trials], np.array([trial.value for trial in trials]))


def held_identity(place: StudyPlace | None) -> Identity | None:
    """The task and the search of the study at a place; None if there is none, or none that can be read."""
    if place is None:
        return None
    try:
        study = place.run(lambda: optuna.load_study(study_name=place.name, storage=place.storage))
        return Identity.model_validate(place.run(lambda: study.user_attrs.get(KEY)))
    except UnavailableError:
        raise
    except (InputError, ValidationError):
        return None
    finally:
        place.close()


def _difference(held: Any, wanted: Any, where: str = "") -> str:
    """The first place in which two plain structures differ."""
    if isinstance(held, dict) and isinstance(wanted, dict):
        for key in [*held, *(k for k in wanted if k not in held)]:
            if held.get(key) != wanted.get(key):
                return _difference(held.get(key), wanted.get(key), f"{where}.{key}" if where else key)
    return f"{where} is {json.dumps(held)} there, {json.dumps(wanted)} here"
