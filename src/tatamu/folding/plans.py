"""The built-in fold plans.

Coordinates are fractions of the garment's length (x, from -0.5 at the hem) and width (y, positive to the left). A
user's own garment has the plans of its kind. If its kind is not known, it has the plans in `ANY`.
"""

from __future__ import annotations

from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.folding.plan import Plan, load_plan
from tatamu.folding.proposals import AUTO_PLAN, best_plan, propose
from tatamu.garments import Garment

THIRD = 0.18
"""Distance from a T-shirt's middle to the lines over which its sides are folded.

It is a fraction of the shirt's width, measured over the sleeves.

The distance is not a sixth, because then the end of the sleeve that is folded first would lie exactly on the second
fold line.
"""


def _across(x: float, **more: object) -> dict[str, object]:
    """Return a fold over a line across the garment's length."""
    return {"line": ((x, -0.5), (x, 0.5)), **more}


def _lengthwise(y: float, **more: object) -> dict[str, object]:
    """Return a fold over a line along the garment's length."""
    return {"line": ((-0.5, y), (0.5, y)), **more}


def _plan(name: str, *steps: dict[str, object]) -> Plan:
    return Plan.model_validate({"name": name, "step": steps})


HALF = _plan("half", _across(0.0, title="in half across the length", moves="-x", area_ratio=0.5))
QUARTERS = _plan(
    "quarters",
    _across(0.0, title="in half across the length", moves="-x", area_ratio=0.5),
    _lengthwise(0.0, title="in half along the length", moves="-y", area_ratio=0.5),
)
ANY = {"half": _plan("half", _across(0.0, title="in half across the length", moves="-x"))}
"""Fold plans that fit every garment, by name."""

PLANS: dict[str, dict[str, Plan]] = {
    "towel": {"half": HALF, "quarters": QUARTERS},
    "tshirt": {
        "half": _plan("half", _across(0.0, title="hem to shoulder", moves="-x", grasp="hem")),
        "shop": _plan(
            "shop",
            _lengthwise(THIRD, title="left third with its sleeve", moves="+y", grasp=("left_sleeve", "hem")),
            _lengthwise(-THIRD, title="right third with its sleeve", moves="-y", grasp=("hem", "right_sleeve")),
            _across(0.0, title="hem up", moves="-x", grasp="hem"),
        ),
    },
    "trousers": {
        "leg": _plan("leg", _lengthwise(0.0, title="leg over leg", moves="-y")),
        "half": _plan(
            "half",
            _lengthwise(0.0, title="leg over leg", moves="-y"),
            _across(0.0, title="hems to waist", moves="-x"),
        ),
        "thirds": _plan(
            "thirds",
            _lengthwise(0.0, title="leg over leg", moves="-y"),
            _across(-1 / 6, title="hems up a third", moves="-x"),
            _across(1 / 6, title="waist over them", moves="+x", grasp="waist"),
        ),
    },
}
"""Built-in fold plans, by the name of the garment and the name of the plan."""


def make_plan(name: str, garment: Garment) -> Plan:
    """Return a plan for a garment. It is read from a .toml file, built in, or proposed for the garment's outline.

    For a user's own garment, `auto` is the best plan for its outline. For other garments, `auto` is the half fold.

    Raises:
        InputError: If there is no such plan, or the file does not contain a valid plan.
    """
    if name.endswith(".toml"):
        return load_plan(Path(name))
    known = known_plans(garment)
    if name == AUTO_PLAN:
        return best_plan(garment) if garment.own else known["half"]
    if name in known:
        return known[name]
    proposed = {proposal.plan.name: proposal.plan for proposal in propose(garment)} if garment.own else {}
    if name not in proposed:
        names = dict.fromkeys([*known, *proposed, AUTO_PLAN] if garment.own else known)
        raise InputError(f"fold: must be one of {', '.join(names)} or a file .toml, given {name!r}")
    return proposed[name]


def known_plans(garment: Garment) -> dict[str, Plan]:
    """Return the built-in plans for a garment, by name. They do not depend on the garment's outline."""
    return PLANS.get(garment.kind if garment.own else garment.name, ANY)
