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


def test_it_says_why_not() -> None:
    constraint = ReachConstraint(load("hironx"))
    assert constraint.refusal(manipulation()) is None
    assert "cannot follow its hand beyond frame" in (constraint.refusal(manipulation(span=0.8)) or "")


def test_a_fold_of_one_hand_is_refused_in_these_words() -> None:
    fold = manipulation()
    one = {**fold, "arms": fold["arms"][:1], "via_points": {**fold["via_points"], "right": None}}
    with pytest.raises(InputError, match=r"arms: must be two, and the fold has one.*--hands 2"):
        ReachConstraint(load("hironx"))(one)
