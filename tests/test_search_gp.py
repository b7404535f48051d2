"""The Gaussian process, its acquisition and the search made of both."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import process_time

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from tatamu import GPSearch, InputError
from tatamu.search import Bounds, Proposal, Space
from tatamu.search.gaussian_process import GaussianProcess, _Posterior
from tatamu.search.gp import APART, log_expected_improvement, log_expected_improvement_beyond
from tatamu.search.space import KnownPart

BOUNDS = {"x": Bounds(-1.0, 3.0), "y": Bounds(0.0, 0.5), "g": Bounds(0, 6, whole=True)}
SPACE = Space(BOUNDS)


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
    parameters = [{"x": -1.0, "y": 0.5, "g": 6}, {"x": 0.25, "y": 0.1, "g": 0}]
    points = SPACE.points(parameters)
    assert ((points >= 0.0) & (points <= 1.0)).all()
    for point, wanted in zip(SPACE.snap(points), parameters, strict=True):
        assert SPACE.parameters(point) == pytest.approx(wanted)


def test_every_whole_number_has_as_much_of_the_cube() -> None:
    drawn = SPACE.values(SPACE.snap(np.random.default_rng(6).random((7000, 3))))["g"]
    counts = np.unique(drawn, return_counts=True)[1]
    assert len(counts) == 7 and counts.min() > 900 and (drawn == np.round(drawn)).all()


def test_parameters_of_a_single_value_are_no_side_of_the_cube_but_are_parameters() -> None:
    space = Space({**BOUNDS, "one": Bounds(3, 3, whole=True)})
    assert space.dimensions == len(BOUNDS)
    points = np.random.default_rng(6).random((4, len(BOUNDS)))
    assert space.values(space.snap(points))["one"].tolist() == [3.0] * 4
    parameters = space.parameters(space.snap(points)[0])
    assert parameters["one"] == 3 and isinstance(parameters["one"], int)
    assert space.points([parameters]) == pytest.approx(space.snap(points)[:1])
    drawn = space.random(5)
    assert drawn["one"] == 3 and isinstance(drawn["one"], int)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"x": 0.0, "y": 0.1}, "g is missing"),
        ({"x": 0.0, "y": 0.1, "g": 0, "h": 1}, "h is missing or unknown"),
        ({"x": 3.1, "y": 0.1, "g": 0}, "^x: must be a number from -1 to 3, given 3.1"),
        ({"x": float("nan"), "y": 0.1, "g": 0}, "^x: must be a number"),
        ({"x": 0.0, "y": "much", "g": 0}, "^y: must be a number"),
        ({"x": 0.0, "y": 0.1, "g": 1.5}, "^g: must be a whole number from 0 to 6, given 1.5"),
    ],
)
def test_parameters_outside_a_space_are_refused_by_name(given: dict[str, object], named: str) -> None:
    with pytest.raises(InputError, match=named):
        SPACE.check(given)
    SPACE.check({"x": 3.0, "y": 0.5, "g": 6})


def length(parameters: Mapping[str, np.ndarray]) -> np.ndarray:
    """What is known of `objective`."""
    return 1.0 + np.abs(parameters["x"])


def objective(parameters: Mapping[str, float]) -> float:
    known = float(length({name: np.array([value]) for name, value in parameters.items()})[0])
    return known + float(np.exp(10.0 * (parameters["y"] - 0.2) ** 2 + 0.3 * (parameters["g"] - 4) ** 2 - 3.0))


def told(count: int, known: KnownPart | None, seed: int = 0) -> GPSearch:
    """A search after so many trials."""
    search = GPSearch(Space(BOUNDS, known_part=known), seed)
    for _ in range(count):
        proposal = search.ask()
        search.tell(proposal, objective(proposal))
    return search


def best(search: GPSearch) -> float:
    return min(each.objective for each in search.told)


def again(search: GPSearch, seed: int) -> GPSearch:
    """A search of another seed that was told the same."""
    other = GPSearch(search.space, seed)
    for each in search.told:
        other.tell(each.parameters, each.objective)
    return other


LEAST = 1.0 + np.exp(-3.0)


def test_with_its_known_part_the_least_objective_is_found_in_twenty_trials() -> None:
    assert max(best(told(20, length, seed)) for seed in range(3)) - LEAST < 0.01


def test_without_a_known_part_it_still_beats_random_trials() -> None:
    random = [objective(SPACE.random(seed)) for seed in range(2000)]
    best_of_twenty = np.reshape(random, (100, 20)).min(axis=1)
    plain = np.median([best(told(20, None, seed)) for seed in range(5)])
    assert plain - LEAST < 0.7 * (np.median(best_of_twenty) - LEAST)


def test_proposals_depend_on_trials_and_seed_alone() -> None:
    search = told(6, length)
    one, other, third = (again(search, seed).ask() for seed in (7, 7, 8))
    assert dict(one) == dict(other) != dict(third)


def test_a_search_that_is_told_the_same_goes_on_in_the_same_way() -> None:
    search = told(5, length, seed=3)
    resumed = again(search, 3)
    for _ in range(3):
        proposals = [each.ask() for each in (search, resumed)]
        assert proposals[0] == proposals[1]
        for each, proposal in zip((search, resumed), proposals, strict=True):
            each.tell(proposal, objective(proposal))


def test_it_keeps_away_from_trials_that_run() -> None:
    search = told(6, length)
    first = again(search, 7).ask()
    waiting = again(search, 7)
    waiting.expect(Proposal({name: first[name] for name in BOUNDS}))
    second = waiting.ask()
    assert np.abs(np.diff(SPACE.points([first, second]), axis=0)).max() > 0.02


def test_no_proposal_is_nearly_a_repetition() -> None:
    """In one dimension, whose best place is soon known, a search would otherwise ask for it again and again."""
    search = GPSearch(Space({"x": Bounds(0.0, 1.0)}), 0)
    for _ in range(20):
        proposal = search.ask()
        search.tell(proposal, (proposal["x"] - 0.3) ** 2)
    known = np.sort([each.parameters["x"] for each in search.told])
    assert np.diff(known).min() >= APART
    for _ in range(20):  # there is no room any more
        search.tell(search.ask(), 1.0)


def test_the_search_sees_even_if_the_best_is_far_from_ideal() -> None:
    """As the last step of a plan may be, which cannot mend what the steps before it left."""
    space = Space({"x": Bounds(0.0, 1.0)}, known_part=lambda at: np.full_like(at["x"], 0.4))
    search = GPSearch(space, 0)
    for _ in range(12):
        proposal = search.ask()
        search.tell(proposal, 1.0 + 2.0 * (proposal["x"] - 0.3) ** 2)
    assert min(abs(each.parameters["x"] - 0.3) for each in search.told) < 0.02


def test_a_search_that_starts_with_failures_that_are_all_alike_looks_elsewhere() -> None:
    """What is known of the objective is least at x = 0, where all that the search starts with is equally bad."""
    first: list[dict[str, int | float]] = [{"x": x} for x in (0.0, 0.05, 0.1)]
    bounds = {"x": Bounds(0.0, 1.0)}
    search = GPSearch(Space(bounds, known_part=lambda at: 0.4 + at["x"]), 0, first)
    asked = []
    for _ in range(4):
        asked.append(dict(search.ask()))
        search.tell(asked[-1], 0.4 + asked[-1]["x"] + 2.0)
    plain = GPSearch(Space(bounds, known_part=lambda at: np.zeros_like(at["x"])), 0, first)
    for parameters in first:
        plain.tell(parameters, 1.0)
    assert asked[:3] == first
    assert asked[3]["x"] > 0.15 and asked[3] == dict(plain.ask()), "it is random"


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_an_objective_that_is_no_number_is_refused(value: float) -> None:
    search = GPSearch(SPACE)
    proposal = search.ask()
    with pytest.raises(InputError, match="objective: must be a finite number"):
        search.tell(proposal, value)


def test_a_proposal_at_fifty_trials_costs_little_beside_a_fold() -> None:
    """Processor time against that of a matrix product of the same run, so neither the machine nor its load matters."""
    search = told(50, length)
    matrix = np.random.default_rng(9).random((500, 500))

    def fastest(work: Callable[[], object], turns: int = 5) -> float:
        seconds = []
        for _ in range(turns):
            started = process_time()
            work()
            seconds.append(process_time() - started)
        return min(seconds)

    proposal = fastest(search.propose)
    product = fastest(lambda: [matrix @ matrix for _ in range(10)])
    assert proposal < 5.0 * product


def test_the_ends_of_a_side_are_the_bounds_to_the_last_bit() -> None:
    random = np.random.default_rng(0)
    for low, high in random.uniform([0.001, 0.2], [0.01, 0.8], (2000, 2)):
        space = Space({"z": Bounds(low, high)})
        for end in (0.0, 1.0):
            assert low <= space.parameters(np.array([end]))["z"] <= high
