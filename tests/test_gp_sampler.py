"""The Gaussian process, its acquisition and the sampler made of both."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

import numpy as np
import optuna
import pytest
from optuna.distributions import FloatDistribution, IntDistribution
from optuna.trial import TrialState, create_trial
from scipy.optimize import approx_fprime
from tatamu.learning.expected_improvement import log_expected_improvement, log_expected_improvement_beyond
from tatamu.learning.gaussian_process import GaussianProcess, _Posterior
from tatamu.learning.gp_sampler import GaussianProcessSampler, KnownPart
from tatamu.learning.unit_cube import UnitCube

SPACE = {"x": FloatDistribution(-1.0, 3.0), "y": FloatDistribution(0.0, 0.5), "g": IntDistribution(0, 6)}


def smooth(points: np.ndarray) -> np.ndarray:
    """A function of the first two of the cube's dimensions."""
    return np.asarray(np.sin(5.0 * points[:, 0]) + (points[:, 1] - 0.3) ** 2)


@pytest.fixture
def process() -> GaussianProcess:
    points = np.random.default_rng(0).random((40, 3))
    return GaussianProcess.fit(points, smooth(points))


def test_the_gradient_of_the_posterior_is_that_of_its_differences() -> None:
    points = np.random.default_rng(1).random((12, 3))
    posterior = _Posterior(points, smooth(points))
    at = np.log([0.3, 0.8, 4.0])
    numeric = approx_fprime(at, lambda each: posterior.loss(each)[0], 1e-6)
    assert posterior.loss(at)[1] == pytest.approx(numeric, rel=1e-4, abs=1e-4)


def test_the_process_passes_through_what_was_observed_and_is_sure_there(process: GaussianProcess) -> None:
    mean, deviation = process.predict(process.points)
    assert mean == pytest.approx(process.values, abs=1e-3)
    assert deviation.max() < 0.01


def test_it_predicts_what_it_has_not_seen_as_well_as_it_says(process: GaussianProcess) -> None:
    points = np.random.default_rng(2).random((200, 3))
    mean, deviation = process.predict(points)
    off = np.abs(mean - smooth(points))
    assert off.mean() < 0.05
    assert 0.7 < (off < 2.0 * deviation).mean()


def test_a_dimension_that_does_not_matter_gets_a_long_length(process: GaussianProcess) -> None:
    assert process.lengths[2] > 3.0 * process.lengths[0]


def test_believing_keeps_the_mean_and_takes_the_doubt_away(process: GaussianProcess) -> None:
    points = np.random.default_rng(3).random((2, 3))
    before = process.predict(points)
    after = process.believing(points).predict(points)
    assert after[0] == pytest.approx(before[0], abs=1e-4)
    assert (after[1] < 0.2 * before[1]).all()


MEANS = np.array([-1.0, 0.0, 0.4, 3.0])
DEVIATIONS = np.array([0.3, 1.0, 0.01, 0.5])


def test_expected_improvement_is_the_integral_that_it_stands_for() -> None:
    normal = np.random.default_rng(4).standard_normal(400_000)
    exact = np.exp(log_expected_improvement(0.5, MEANS, DEVIATIONS))
    sampled = [np.maximum(0.5 - (m + s * normal), 0.0).mean() for m, s in zip(MEANS, DEVIATIONS, strict=True)]
    assert exact == pytest.approx(sampled, rel=0.02, abs=1e-6)


def test_expected_improvement_beyond_a_known_part_is_the_integral_that_it_stands_for() -> None:
    normal = np.random.default_rng(5).standard_normal(400_000)
    known = np.array([0.2, 0.9, 0.3, 0.1])
    exact = np.exp(log_expected_improvement_beyond(2.0, known, MEANS, DEVIATIONS))
    sampled = [
        np.maximum(2.0 - l_x - np.exp(m + s * normal), 0.0).mean()
        for l_x, m, s in zip(known, MEANS, DEVIATIONS, strict=True)
    ]
    assert exact == pytest.approx(sampled, rel=0.02, abs=1e-5)


def test_far_from_the_best_improvement_is_small_and_still_told_apart() -> None:
    far = log_expected_improvement(0.0, np.array([20.0, 40.0]), np.ones(2))
    assert np.isfinite(far).all() and far[0] > far[1]
    beyond = log_expected_improvement_beyond(1.0, np.array([0.0, 2.0]), np.zeros(2), np.ones(2))
    assert np.isfinite(beyond[0]) and beyond[1] == -np.inf


def test_parameters_survive_the_cube() -> None:
    cube = UnitCube(SPACE)
    parameters = [{"x": -1.0, "y": 0.5, "g": 6}, {"x": 0.25, "y": 0.1, "g": 0}]
    points = cube.points(parameters)
    assert ((points >= 0.0) & (points <= 1.0)).all()
    for point, wanted in zip(cube.snapped(points), parameters, strict=True):
        assert cube.parameters(point) == pytest.approx(wanted)


def test_every_whole_number_has_as_much_of_the_cube() -> None:
    cube = UnitCube(SPACE)
    drawn = cube.values(cube.snapped(np.random.default_rng(6).random((7000, 3))))["g"]
    counts = np.unique(drawn, return_counts=True)[1]
    assert len(counts) == 7 and counts.min() > 900 and (drawn == np.round(drawn)).all()


def test_parameters_of_a_single_value_are_no_side_of_the_cube_but_are_parameters() -> None:
    cube = UnitCube({**SPACE, "one": IntDistribution(3, 3)})
    assert cube.dimensions == len(SPACE)
    points = np.random.default_rng(6).random((4, len(SPACE)))
    assert cube.values(cube.snapped(points))["one"].tolist() == [3.0] * 4
    parameters = cube.parameters(cube.snapped(points)[0])
    assert parameters["one"] == 3 and isinstance(parameters["one"], int)
    assert cube.points([parameters]) == pytest.approx(cube.snapped(points)[:1])


def length(parameters: Mapping[str, np.ndarray]) -> np.ndarray:
    """What is known of `objective`."""
    return 1.0 + np.abs(parameters["x"])


def objective(parameters: Mapping[str, float]) -> float:
    known = float(length({name: np.array([value]) for name, value in parameters.items()})[0])
    return known + float(np.exp(10.0 * (parameters["y"] - 0.2) ** 2 + 0.3 * (parameters["g"] - 4) ** 2 - 3.0))


def told(count: int, known: KnownPart | None, seed: int = 0) -> optuna.Study:
    """A study of so many trials, each by a sampler of its own."""
    study = optuna.create_study(direction="minimize")
    for number in range(count):
        study.sampler = GaussianProcessSampler(seed=1000 * seed + number, known=known)
        trial = study.ask(SPACE)
        study.tell(trial, objective(trial.params))
    return study


LEAST = 1.0 + np.exp(-3.0)


def test_with_its_known_part_the_least_objective_is_found_in_twenty_trials() -> None:
    assert max(told(20, length, seed).best_value for seed in range(3)) - LEAST < 0.01


def test_without_a_known_part_it_still_beats_random_trials() -> None:
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    random = [objective(study.ask(SPACE).params) for _ in range(2000)]
    best_of_twenty = np.reshape(random, (100, 20)).min(axis=1)
    plain = np.median([told(20, None, seed).best_value for seed in range(5)])
    assert plain - LEAST < 0.7 * (np.median(best_of_twenty) - LEAST)


def test_proposals_depend_on_trials_and_seed_alone() -> None:
    study = told(6, length)
    one, other, third = (
        GaussianProcessSampler(seed=seed, known=length).sample_relative(study, study.trials[-1], SPACE)
        for seed in (7, 7, 8)
    )
    assert one == other != third


def test_it_keeps_away_from_trials_that_run() -> None:
    study = told(6, length)
    sampler = GaussianProcessSampler(seed=7, known=length)
    first = sampler.sample_relative(study, study.trials[-1], SPACE)
    study.add_trial(create_trial(state=TrialState.RUNNING, params=first, distributions=SPACE))
    second = GaussianProcessSampler(seed=7, known=length).sample_relative(study, study.trials[-1], SPACE)
    cube = UnitCube(SPACE)
    assert np.abs(np.diff(cube.points([first, second]), axis=0)).max() > 0.02


def test_a_proposal_at_fifty_trials_costs_little_beside_a_fold() -> None:
    """Against a matrix product of the same run: the machine's pace cancels."""
    study = told(50, length)
    matrix = np.random.default_rng(9).random((500, 500))

    def fastest(work: object, turns: int = 5) -> float:
        seconds = []
        for _ in range(turns):
            started = perf_counter()
            work()  # type: ignore[operator]
            seconds.append(perf_counter() - started)
        return min(seconds)

    proposal = fastest(lambda: GaussianProcessSampler(3, length).sample_relative(study, study.trials[-1], SPACE))
    product = fastest(lambda: [matrix @ matrix for _ in range(10)])
    assert proposal < 5.0 * product


def test_the_ends_of_a_side_are_the_bounds_to_the_last_bit() -> None:
    random = np.random.default_rng(0)
    for low, high in random.uniform([0.001, 0.2], [0.01, 0.8], (2000, 2)):
        space = {"z": FloatDistribution(low, high)}
        cube = UnitCube(space)
        for end in (0.0, 1.0):
            assert space["z"].low <= cube.parameters(np.array([end]))["z"] <= space["z"].high
