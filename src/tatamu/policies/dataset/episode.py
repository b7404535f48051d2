"""One episode: a fold is drawn at random, hands or arms carry it out step by step, and the outcome is scored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.base.errors import InputError, SimulationError
from tatamu.evaluation.disturbances import Disturbances, Stream, sample_scenarios
from tatamu.evaluation.nominal import Nominal
from tatamu.folding.manipulation import SETTLE
from tatamu.folding.score import score
from tatamu.folding.task import Task
from tatamu.policies.dataset.arms import OutOfReachError, Stand, arms_at
from tatamu.policies.dataset.record import EpisodeRecord, fields_of
from tatamu.policies.dataset.sources import DrawnFold, draw_fold, parameters_of
from tatamu.policies.dataset.specification import DatasetSpecification
from tatamu.policies.envs.cameras import Studio
from tatamu.policies.envs.environment import draw_scenario
from tatamu.policies.envs.hands import HandsEnv
from tatamu.policies.envs.motion import Led, actions_of, lead
from tatamu.search import Parameters
from tatamu.simulation.simulators import named

SECONDS = 120.0
"""Largest duration of an episode [s]."""


@dataclass(frozen=True)
class Recorder:
    """What all episodes share."""

    specification: DatasetSpecification
    runs: Sequence[DrawnFold]
    disturbances: Disturbances | None
    stand: Stand | None
    """None for floating hands."""


@dataclass(frozen=True)
class Episode:
    """The recorded data of an episode."""

    record: EpisodeRecord
    arrays: Mapping[str, np.ndarray]
    """Arrays of T actions, by name, for s numbers in a state, a in an action, and pictures of p x p pixels.

    - `state` (T + 1, s), `action` (T, a) and `reward` (T,)
    - `key_points` (T + 1, k, 3) and `positions` (T + 1, n, 3) [m]
    - `hands` (T + 1, 4 h): position [m] of each hand, and whether it holds cloth
    - `mask` (T + 1, p, p): 1 where cloth is seen from above; only for Zarr
    - `faces` (m, 3); `final` (n, 3) [m]: final positions in double precision
    - `camera.NAME` (T + 1, p, p, 3); `thumbnail` (p, p, 3): picture of the outcome, only in the first episodes
    """


@dataclass(frozen=True)
class _Prepared:
    """A fold that has been drawn."""

    drawn: DrawnFold
    task: Task
    parameters: Parameters
    actions: np.ndarray
    """float32, shape (T, a); at the end, the open hands wait for `SETTLE` seconds."""
    states: np.ndarray | None
    """float32, shape (T + 1, a), before the first step and after each step; None for floating hands."""


def record_episode(recorder: Recorder, number: int) -> Episode:
    """Record an episode. The same arguments give the same bytes in every process.

    Raises:
        InputError: If the robot can carry out none of the folds that were drawn.
    """
    specification = recorder.specification
    prepared = _prepare(recorder, number // specification.per_fold)
    generator = np.random.default_rng(np.random.SeedSequence([specification.seed, 1, number]))
    scenario = draw_scenario(recorder.disturbances, generator)
    env = make_env(prepared.task, specification)
    first, _ = env.reset(options={"world": scenario.values})
    answers = play(env, prepared.actions, recorder.stand)
    info = answers[-1][4]
    final, reached = env.outcome()
    task = prepared.task
    record = EpisodeRecord(
        **prepared.drawn.subject.model_copy(update={"material": fields_of(task.garment.material)}).model_dump(),
        episode=number,
        fold=number // specification.per_fold,
        task=f"Fold the {task.garment.name}: {task.title}.",
        source=prepared.drawn.source,
        parameters={name: float(value) for name, value in prepared.parameters.items()},
        world={name: value for name, value in scenario.values.items() if value},
        frames=len(answers),
        vertices=len(final),
        success=bool(info["is_success"]),
        error=info["error"],
        score=None if info["error"] else reached,
    )
    arrays = _seen([first, *(answer[0] for answer in answers)])
    arrays |= {
        "state": arrays["hands"] if prepared.states is None else prepared.states[: len(answers) + 1],
        "action": prepared.actions[: len(answers)],
        "reward": np.array([answer[1] for answer in answers], dtype=np.float32),
        "final": final,
        "faces": task.garment.faces.astype(np.int32),
    }
    if number < 24:  # the dataset's page shows the outcomes of the first episodes
        studio = Studio(task.fold.start, task.garment.faces, pixels=192)
        arrays["thumbnail"] = studio.picture("front", final)
    return Episode(_judged(record, recorder, prepared, env), arrays)


def make_env(task: Task, specification: DatasetSpecification) -> HandsEnv:
    """Return the environment for the episodes of a specification."""
    mask = ("mask",) if "zarr" in specification.formats else ()
    observation = ("vertices", "key_points", "hands", *mask, *specification.cameras)
    options = specification.record
    return HandsEnv(task, rate=options.fps, seconds=SECONDS, observation=observation, pixels=options.pixels)


def play(
    env: HandsEnv, actions: np.ndarray, stand: Stand | None
) -> list[tuple[Any, float, bool, bool, dict[str, Any]]]:
    """Carry out actions until they or the episode end, and return the results of all steps.

    Args:
        env: The environment, after its reset.
        actions: Actions, float32, shape (T, a).
        stand: The robot whose joints the actions move; None for floating hands.
    """
    places, closed = (None, None) if stand is None else arms_at(stand).places(actions)
    answers = []
    for number, action in enumerate(actions):
        moved = env.step(action) if places is None or closed is None else env.lead(places[number], closed[number])
        answers.append(moved)
        if moved[2] or moved[3]:
            break
    return answers


def _prepare(recorder: Recorder, fold: int) -> _Prepared:
    """Draw folds until the arms can carry out one."""
    reason = ""
    attempts = 50
    for attempt in range(attempts):
        drawn = draw_fold(recorder.specification, recorder.runs, fold, attempt)
        task = drawn.subject.make_task()
        parameters = parameters_of(drawn, task, recorder.specification.fold.spread)
        try:
            return _Prepared(drawn, task, parameters, *_planned(recorder, task, parameters))
        except OutOfReachError as error:
            reason = str(error)
    assert recorder.stand is not None
    raise InputError(
        f"robot: {recorder.stand.robot} can do none of {attempts} random folds of this dataset; the last one "
        f"fails because {reason}"
    )


def _planned(recorder: Recorder, task: Task, parameters: Parameters) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the actions of a fold, and the states of the robot; None for floating hands."""
    rate = recorder.specification.record.fps
    env = HandsEnv(task, rate=rate, seconds=SECONDS, observation="key_points")
    manipulation = task.manipulation(parameters)
    wait = int(np.ceil(SETTLE * rate))

    def led(largest: float) -> Led:
        return lead(manipulation, env.start, largest, rate)

    if recorder.stand is None:
        return actions_of(led(env.largest), env.start, env.largest, wait), None
    arms = arms_at(recorder.stand)
    states = arms.follow(led, env.largest, env.start, rate)
    states = np.concatenate([states, np.repeat(arms.opened(states[-1])[None], wait, axis=0)])
    return states[1:], states


def _seen(observations: Sequence[Any]) -> dict[str, np.ndarray]:
    """Return the observations of all frames by their names in `Episode.arrays`."""
    stacked = {name: np.stack([each[name] for each in observations]) for name in observations[0]}
    plain = {"vertices": "positions", "key_points": "key_points", "hands": "hands", "mask": "mask"}
    return {plain.get(name, f"camera.{name}"): value for name, value in stacked.items()}


def _judged(record: EpisodeRecord, recorder: Recorder, prepared: _Prepared, env: HandsEnv) -> EpisodeRecord:
    """Return the record with the success rate of its fold and the second simulator's outcome, if known or wanted."""
    outcome = recorder.specification.outcome
    if prepared.drawn.known is not None and not recorder.specification.fold.spread:
        record = record.with_share(*prepared.drawn.known)
    elif outcome.worlds and recorder.disturbances and record.episode % recorder.specification.per_fold == 0:
        scenarios = sample_scenarios(recorder.disturbances, outcome.worlds, recorder.specification.seed, Stream.MARGINS)
        found = [Nominal(prepared.task).simulate(prepared.parameters, scenario).score for scenario in scenarios]
        record = record.with_share(sum(each is not None and each.succeeds for each in found), len(found), "worlds")
    if outcome.simulator is None:
        return record
    second: dict[str, Any] = {"second_simulator": outcome.simulator, "second_success": False}
    try:
        final = named(outcome.simulator).simulate(env.scene()).positions[-1]
    except SimulationError:
        return record.model_copy(update=second)
    again = score(prepared.task.fold, 0.0, final)
    second |= {"second_success": again.succeeds, "second_mean_vertex_distance": again.mean_vertex_distance}
    return record.model_copy(update=second)
