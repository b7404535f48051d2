from dataclasses import replace
from typing import Any

import pytest

from tatamu.base.errors import InputError
from tatamu.robots import ReachConstraint, Robot, load
from tatamu.robots.hands import HandMotion
from tatamu.robots.placement import Placement
from tatamu.robots.reach import Rated, search
from tests.robots.folds import exact


def test_a_fold_within_reach_is_positive_and_a_long_one_negative() -> None:
    constraint = ReachConstraint(load("hironx"))
    assert 0 <= constraint(exact()) <= 1
    assert constraint(exact(span=0.8)) < 0


def test_an_answer_does_not_depend_on_earlier_answers() -> None:
    folds = [exact(), exact(shift=0.3), exact(span=0.55), exact(height=0.14)]
    constraint = ReachConstraint(load("hironx"))
    found = [constraint(fold) for fold in folds]
    assert [quality >= 0 for quality in found] == [True, True, False, True]
    assert [ReachConstraint(load("hironx"))(fold) for fold in folds[::-1]] == found[::-1]


def test_a_fold_that_cannot_lie_straight_ahead_is_searched_for_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def counted(robot: Robot, hands: HandMotion, placements: list[Placement], **options: Any) -> list[Rated]:
        asked.append(len(placements))
        found = search(robot, hands, placements, **options)
        return [each._replace(quality=each.quality - 2) for each in found] if len(asked) == 1 else found

    monkeypatch.setattr("tatamu.robots.reach.search", counted)
    assert ReachConstraint(load("hironx"))(exact()) >= 0
    assert len(asked) == 3 and asked[0] < asked[1] / 10


def test_it_names_what_is_wrong() -> None:
    with pytest.raises(InputError, match="arms"):
        ReachConstraint(load("hironx"))(replace(exact(), hands=()))


def test_it_says_why_not() -> None:
    constraint = ReachConstraint(load("hironx"))
    assert constraint.refusal(exact()) is None
    assert "cannot follow its hand beyond frame" in (constraint.refusal(exact(span=0.8)) or "")
