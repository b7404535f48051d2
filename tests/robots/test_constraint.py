import pytest

from tests.robots.folds import manipulation

pytest.importorskip("mujoco")

from tatamu.errors import InputError
from tatamu.robots import ReachConstraint, load


def test_a_fold_within_reach_is_positive_and_a_long_one_negative() -> None:
    constraint = ReachConstraint(load("hironx"))
    assert 0 <= constraint(manipulation()) <= 1
    assert constraint(manipulation(span=0.8)) < 0


def test_what_it_remembers_does_not_make_a_bad_fold_good() -> None:
    constraint = ReachConstraint(load("hironx"))
    constraint(manipulation())
    assert constraint(manipulation(span=0.55)) < 0
    assert constraint(manipulation(height=0.14)) >= 0


def test_a_fold_that_needs_another_place_is_searched_for_again() -> None:
    constraint = ReachConstraint(load("hironx"))
    constraint(manipulation())
    assert constraint(manipulation(shift=0.3)) >= 0


def test_it_names_what_is_wrong() -> None:
    with pytest.raises(InputError, match="arms"):
        ReachConstraint(load("hironx"))({**manipulation(), "arms": []})
