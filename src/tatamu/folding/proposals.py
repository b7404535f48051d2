"""Fold plans for a garment by its outline: what stands off the body goes in first, then the body is folded in half.

Proposed are lines, the sides that move, their order, and the edges to grasp; what no hand would carry is found as
`coverage` finds it, and plans without such parts come first. Nothing is simulated.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.errors import InputError
from tatamu.folding.appendages import Appendage, appendages, has_legs, silhouette
from tatamu.folding.coverage import Part, uncarried
from tatamu.folding.grasps import candidates
from tatamu.folding.ideal import Line, crease_of
from tatamu.folding.plan import Plan, line_of
from tatamu.garments import Garment

AUTO_PLAN = "auto"
"""The name under which the best proposal is asked for."""
TWO_HANDS = 0.15
"""An edge at least this long along the fold line is grasped by both hands [m]; a cuff by one."""
SIDES = ("bottom", "top", "left", "right")
"""Names that edges have when nobody gave them one, as `garments.sides` has them."""


@dataclass(frozen=True)
class Proposal:
    """A fold plan that suits a garment's outline."""

    plan: Plan
    uncarried: tuple[tuple[int, Part], ...]
    """What no hand carries: number of the step, the first being 0, and the part."""

    @property
    def text(self) -> str:
        """The steps in a few words."""
        return ", ".join(step.title for step in self.plan.steps)


def propose(garment: Garment) -> list[Proposal]:
    """Fold plans for a garment, the best first.

    Raises:
        InputError: No line is found that it can be folded over.
    """
    found = [proposal for plan in _sequences(garment) if (proposal := _tried(garment, *plan))]
    if not found:
        raise InputError(f"fold: no plan is found for {garment.name}; write one (docs/folds.md)")
    return sorted(found, key=lambda proposal: bool(proposal.uncarried))  # a stable sort: else in the order proposed


def best_plan(garment: Garment) -> Plan:
    """The best proposal for a garment, under the name by which it is asked for.

    Raises:
        InputError: No line is found that it can be folded over.
    """
    return propose(garment)[0].plan


def _sequences(garment: Garment) -> list[tuple[str, list[_Fold]]]:
    """Names of plans and their folds in order; the first is what most people do."""
    outline = silhouette(garment)
    parts = appendages(outline)
    inwards = [_Inwards(part, _title(garment, part, parts)) for part in parts]
    sideways = [fold for fold in inwards if fold.part.facing in ("+y", "-y")]
    across, lengthwise = _Halving("x"), _Halving("y")
    low_x, low_y, high_x, high_y = outline.bounds
    endings: list[tuple[str, list[_Fold]]] = [("half", [across]), ("lengthwise", [lengthwise])]
    if has_legs(outline):
        endings = [("half", [lengthwise, across]), ("leg", [lengthwise])]
    elif not parts and high_y - low_y > high_x - low_x:
        endings.reverse()
    endings.append(("quarters", [across, lengthwise]))
    starts: list[tuple[str, list[_Fold]]] = [("", [])]
    if sideways and len(sideways) < len(inwards):
        starts.insert(0, ("sides-", list(sideways)))
    if inwards:
        starts.insert(0, ("in-", list(inwards)))
    return [(begin + end, [*first, *last]) for begin, first in starts for end, last in endings]


def _title(garment: Garment, part: Appendage, parts: list[Appendage]) -> str:
    """What an appendage is called."""
    pair = {"+y", "-y"} <= {each.facing for each in parts}
    if part.facing in ("+y", "-y"):
        return f"{'left' if part.facing == '+y' else 'right'} {'sleeve' if pair else 'side'} in"
    end = _farthest_edge(garment, garment.vertices, _line(part))
    own = not any(end == side or end.startswith(f"{side} ") for side in SIDES)
    name = end if own else "top" if part.facing == "+x" else "bottom"
    return f"{name} {'down' if part.facing == '+x' else 'up'}"


@dataclass(frozen=True)
class _Inwards:
    """A fold that lays an appendage on the body."""

    part: Appendage
    title: str

    def step(self, state: np.ndarray) -> dict[str, Any]:
        return {"title": self.title, "moves": self.part.facing, "at": self.part.line}


@dataclass(frozen=True)
class _Halving:
    """A fold over the middle of what the garment then covers."""

    axis: str

    def step(self, state: np.ndarray) -> dict[str, Any]:
        column = 0 if self.axis == "x" else 1
        at = 0.5 * float(state[:, column].min() + state[:, column].max())
        how = "across" if self.axis == "x" else "along"
        return {"title": f"in half {how} the length", "moves": f"-{self.axis}", "at": at}


_Fold = _Inwards | _Halving


def _line(part: Appendage) -> Line:
    return line_of(_ends(part.facing, part.line, 0.5, 0.5), part.facing)


def _ends(moves: str, at: float, half_length: float, half_width: float) -> np.ndarray:
    """Two points of the line at x or y = `at`, shape (2, 2)."""
    if moves[1] == "x":
        return np.array([[at, -half_width], [at, half_width]])
    return np.array([[-half_length, at], [half_length, at]])


def _tried(garment: Garment, name: str, folds: list[_Fold]) -> Proposal | None:
    """The proposal of these folds; None where one of them cannot be."""
    state = garment.vertices
    steps: list[dict[str, Any]] = []
    missed: list[tuple[int, Part]] = []
    width, length = garment.size
    for number, fold in enumerate(folds):
        wanted = fold.step(state)
        at = round(wanted["at"] / (length if wanted["moves"][1] == "x" else width), 4)
        step = {
            "title": wanted["title"],
            "line": _ends(wanted["moves"], at, 0.5, 0.5).tolist(),
            "moves": wanted["moves"],
        }
        try:
            step, part, state = _folded(garment, state, step)
        except InputError:
            return None
        steps.append(step)
        missed += [(number, each) for each in part]
    return Proposal(Plan.model_validate({"name": name, "step": steps}), tuple(missed))


def _folded(
    garment: Garment, state: np.ndarray, given: dict[str, Any]
) -> tuple[dict[str, Any], tuple[Part, ...], np.ndarray]:
    """A step with its grasps, what of it no hand carries, and the cloth after it [m], shape (n, 3).

    Raises:
        InputError: The step cannot be folded.
    """
    draft = Plan.model_validate({"name": "draft", "step": [given]})
    line = draft.line(draft.steps[0], garment)
    across, along = line.split(state)
    if -across.min() < crease_of(garment, garment.material.thickness).arc[-1]:
        raise InputError("fold: the side that moves is narrower than a crease")
    edge = _farthest_edge(garment, state, line)
    hands = 2 if _extent(garment, state, line, edge) >= TWO_HANDS else 1
    step = {**given, "grasp": edge, **({"hands": 1} if hands == 1 else {})}
    full = Plan.model_validate({"name": "draft", "step": [step]}).steps[0]
    chosen = candidates(garment, state, line, full, hands)[:hands]
    return step, uncarried(garment, state, line, chosen), _laid(garment, state, line)


def _farthest_edge(garment: Garment, state: np.ndarray, line: Line) -> str:
    """The edge whose part on the moving side is on average farthest from the line."""
    away = {name: _away(state, line, path) for name, path in garment.edges.items()}
    reach = {name: float(far[far >= 0.5 * far.max()].mean()) for name, far in away.items() if far.max() > 0}
    if not reach:
        raise InputError("fold: no edge of the garment lies on the moving side of the fold line")
    return max(reach, key=lambda name: reach[name])


def _away(state: np.ndarray, line: Line, path: np.ndarray) -> np.ndarray:
    return -line.split(state[np.unique(path)])[0]


def _extent(garment: Garment, state: np.ndarray, line: Line, edge: str) -> float:
    """How long the far part of an edge is along the line [m]."""
    across, along = line.split(state[np.unique(garment.edges[edge])])
    far = -across >= 0.5 * float((-across).max())
    return float(np.ptp(along[far]))


def _laid(garment: Garment, state: np.ndarray, line: Line) -> np.ndarray:
    """The cloth with the moving side turned over the line, flat and on top [m], shape (n, 3)."""
    across, _ = line.split(state)
    moving = across < 0
    laid = state.copy()
    laid[moving, :2] = line.mirrored(state)[moving]
    top = float(state[:, 2].max()) + garment.material.thickness
    laid[moving, 2] = 2.0 * top - state[moving, 2]
    return laid
