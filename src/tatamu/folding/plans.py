"""The built-in fold plans: files in `data/`, by the kind of garment.

A user's own garment has the plans of its kind, or those in `ANY` if its kind is not known.
"""

from __future__ import annotations

from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.folding.plan import Plan, load_plan
from tatamu.folding.proposals import AUTO_PLAN, propose
from tatamu.garments import Garment


def _plans(kind: str, *names: str) -> dict[str, Plan]:
    return {name: load_plan(Path(__file__).parent / "data" / kind / f"{name}.toml") for name in names}


PLANS = {
    "towel": _plans("towel", "half", "quarters"),
    "tshirt": _plans("tshirt", "half", "shop"),
    "trousers": _plans("trousers", "leg", "half", "thirds"),
}
"""Plans of each kind of garment, by name, in the order in which they are listed."""
ANY = _plans("any", "half")
"""Plans that fit every garment, by name."""


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
