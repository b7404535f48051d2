"""The built-in fold plans.

Coordinates are fractions of the garment's length (x, from -0.5 at the hem) and width (y, positive to the left). A
user's own garment has the plans of its kind, or those in `ANY` if its kind is not known.
"""

from __future__ import annotations

from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.folding.plan import Plan, load_plan
from tatamu.folding.proposals import AUTO_PLAN, propose
from tatamu.garments import Garment

THIRD = 0.18
"""Distance from a T-shirt's middle to its lengthwise fold lines, as a fraction of its width over the sleeves. With a
sixth, the end of the sleeve folded first would lie exactly on the second line."""


def _across(x: float, **more: object) -> dict[str, object]:
    return {"line": ((x, -0.5), (x, 0.5)), **more}


def _lengthwise(y: float, **more: object) -> dict[str, object]:
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
"""Plans that fit every garment, by name."""

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


def make_plan(name: str, garment: Garment) -> Plan:
    """Return a plan from a .toml file, a built-in one, or one that is proposed for the garment's outline.

    `auto` is the best plan for the outline of a user's own garment, and the half fold for others.
    """
    if name.endswith(".toml"):
        return load_plan(Path(name))
    known = known_plans(garment)
    if name == AUTO_PLAN:
        return propose(garment)[0].plan if garment.own else known["half"]
    if name in known:
        return known[name]
    proposed = {proposal.plan.name: proposal.plan for proposal in propose(garment)} if garment.own else {}
    if name not in proposed:
        names = dict.fromkeys([*known, *proposed, AUTO_PLAN] if garment.own else known)
        raise InputError(f"fold: must be one of {', '.join(names)} or a .toml file, given {name!r}")
    return proposed[name]


def known_plans(garment: Garment) -> dict[str, Plan]:
    """Return the built-in plans for a garment, by name."""
    return PLANS.get(garment.kind if garment.own else garment.name, ANY)
