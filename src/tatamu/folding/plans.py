"""The fold plans of a garment: built-in ones, and those that are proposed for the outline of a user's garment.

The built-in plans are files in `data/`, by the kind of garment. A user's own garment has the plans of its kind, or
those in `ANY` if its kind is not known.

A proposed plan folds the parts that stick out in, then the body in half. Plans that leave no cloth behind come first
(`coverage`). Nothing is simulated.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.appendages import Appendage, appendages, has_legs, silhouette
from tatamu.folding.coverage import Part, covered, grasp_for
from tatamu.folding.grasps import farthest_edge
from tatamu.folding.ideal import crease_of
from tatamu.folding.layout import Layout
from tatamu.folding.plan import Plan, line_of, load_plan
from tatamu.garments import Garment

AUTO_PLAN = "auto"
SIDES = ("bottom", "top", "left", "right")
"""Names that `tatamu.garments.outline` gives to edges without a name."""


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


@dataclass(frozen=True)
class Proposal:
    """A fold plan that suits a garment's outline."""

    plan: Plan
    missed: tuple[tuple[int, Part], ...]
    """Parts of the cloth that no hand carries, each with the index of its step."""
    short: bool = False
    """Whether a folded part is so narrow, compared with its crease, that it hardly lies flat."""

    @property
    def text(self) -> str:
        return ", ".join(step.title for step in self.plan.steps)


def propose(garment: Garment) -> list[Proposal]:
    """Return fold plans for a garment, the best first.

    Raises:
        InputError: If no line is found over which the garment can be folded.
    """
    known: dict[tuple[_Fold, ...], _Folded | None] = {(): _Folded((), (), False, garment.vertices)}
    found = [
        Proposal(Plan.model_validate({"name": name, "step": folded.steps}), folded.missed, folded.short)
        for name, folds in _sequences(garment)
        if (folded := _folded(garment, tuple(folds), known))
    ]
    if not found:
        raise InputError(
            f"fold: must be a plan file, because no fold plan was found for {garment.name}; write a plan file "
            "(docs/reference/fold-plan.md)"
        )
    return sorted(
        found, key=lambda each: (bool(each.missed), each.short)
    )  # The sort is stable, so equally good proposals keep their order.


def _sequences(garment: Garment) -> list[tuple[str, list[_Fold]]]:
    """Return the names and the folds of plans to try, the most common plan for such a garment first."""
    outline = silhouette(garment)
    legs = has_legs(outline)
    parts = [part for part in appendages(outline) if not (legs and part.facing == "-x")]
    inwards = [_Fold(_title(garment, part, parts), part.facing, part.line) for part in parts]
    sideways = [fold for fold in inwards if fold.moves in ("+y", "-y")]
    across, lengthwise = _Fold("in half across the length", "-x"), _Fold("in half along the length", "-y")
    low_x, low_y, high_x, high_y = outline.bounds
    endings: list[tuple[str, list[_Fold]]] = [("half", [across]), ("lengthwise", [lengthwise])]
    if legs:
        endings = [("legs-half", [lengthwise, across]), ("legs", [lengthwise]), ("half", [across])]
    elif not parts and high_y - low_y > high_x - low_x:
        endings.reverse()
    endings.append(("quarters", [across, lengthwise]))
    starts: list[tuple[str, list[_Fold]]] = [("", [])]
    if sideways and len(sideways) < len(inwards):
        starts.insert(0, ("sides-", sideways))
    if inwards:
        starts.insert(0, ("in-", inwards))
    return [(begin + end, [*first, *last]) for begin, first in starts for end, last in endings]


def _title(garment: Garment, part: Appendage, parts: list[Appendage]) -> str:
    pair = {"+y", "-y"} <= {each.facing for each in parts}
    if part.facing in ("+y", "-y"):
        return f"{'left' if part.facing == '+y' else 'right'} {'sleeve' if pair else 'side'} in"
    line = line_of(_ends(part.facing, part.line), part.facing)
    end = farthest_edge(Layout(garment, garment.vertices, line))
    own = not any(end == side or end.startswith(f"{side} ") for side in SIDES)
    name = end if own else "top" if part.facing == "+x" else "bottom"
    return f"{name} {'down' if part.facing == '+x' else 'up'}"


class _Fold(NamedTuple):
    """A fold over a line that is parallel to the x or the y axis."""

    title: str
    moves: str
    at: float | None = None
    """Its x or y coordinate [m]; None for the middle of the area that the garment covers after the earlier folds."""


def _ends(moves: str, at: float) -> np.ndarray:
    return np.array([[at, -0.5], [at, 0.5]] if moves[1] == "x" else [[-0.5, at], [0.5, at]])


@dataclass(frozen=True)
class _Folded:
    """A garment after some folds, each of them flat."""

    steps: tuple[dict[str, Any], ...]
    missed: tuple[tuple[int, Part], ...]
    short: bool
    state: np.ndarray
    """Positions [m], shape (n, 3)."""


def _folded(
    garment: Garment, folds: tuple[_Fold, ...], known: dict[tuple[_Fold, ...], _Folded | None]
) -> _Folded | None:
    """Return the garment after folds, from `known` if it is there; None if a fold is impossible."""
    if folds not in known:
        before = _folded(garment, folds[:-1], known)
        try:
            known[folds] = before and _folded_once(garment, before, folds[-1])
        except InputError:
            known[folds] = None
    return known[folds]


def _folded_once(garment: Garment, before: _Folded, fold: _Fold) -> _Folded:
    state, column = before.state, 0 if fold.moves[1] == "x" else 1
    middle = 0.5 * float(state[:, column].min() + state[:, column].max())
    at = round((middle if fold.at is None else fold.at) / garment.size[1 - column], 4) + 0.0  # no negative zero
    step: dict[str, Any] = {"title": fold.title, "line": _ends(fold.moves, at).tolist(), "moves": fold.moves}
    draft = Plan.model_validate({"name": "draft", "step": [step]})
    layout = Layout(garment, state, draft.line(draft.steps[0], garment))
    flap = float(-layout.split()[0].min())
    crease = float(crease_of(garment, garment.material.thickness).arc[-1])
    if flap < crease:
        raise InputError("fold: the moving side must be wider than a crease")
    grasp, hands = grasp_for(layout)
    step["grasp"] = grasp[0] if len(grasp) == 1 else list(grasp)
    if hands == 1:
        step["hands"] = 1
    missed = tuple((len(before.steps), part) for part in covered(layout, grasp, hands))
    stacked = bool(before.steps) or fold.at is not None
    short = before.short or (stacked and flap < 2.0 * crease)  # it would be mostly loop
    return _Folded((*before.steps, step), (*before.missed, *missed), short, layout.laid())
