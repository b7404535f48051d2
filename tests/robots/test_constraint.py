from dataclasses import replace

import pytest

from tests.robots.folds import exact

pytest.importorskip("mujoco")

from tatamu.base.errors import InputError
from tatamu.robots import ReachConstraint, load


def test_a_fold_within_reach_is_positive_and_a_long_one_negative() -> None:
    constraint = ReachConstraint(load("hironx"))
    assert 0 <= constraint(exact()) <= 1
    assert constraint(exact(span=0.8)) < 0


@pytest.mark.slow
def test_what_it_remembers_does_not_make_a_bad_fold_good() -> None:
    constraint = ReachConstraint(load("hironx"))
    constraint(exact())
    assert constraint(exact(span=0.55)) < 0
    assert constraint(exact(height=0.14)) >= 0


def test_a_fold_that_needs_another_place_is_searched_for_again() -> None:
    constraint = ReachConstraint(load("hironx"))
    constraint(exact())
    assert constraint(exact(shift=0.3)) >= 0


def test_it_names_what_is_wrong() -> None:
    with pytest.raises(InputError, match="arms"):
        ReachConstraint(load("hironx"))(replace(exact(), grasps=(), positions=(), paths=(), control_points=()))


def test_it_says_why_not() -> None:
    constraint = ReachConstraint(load("hironx"))
    assert constraint.refusal(exact()) is None
    assert "cannot follow its hand beyond frame" in (constraint.refusal(exact(span=0.8)) or "")
