"""A fold of a garment as it lies: the line, the target shape, and the vertices where hands may grasp."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tatamu.errors import InputError
from tatamu.folding.fingers import PAD, Fingers
from tatamu.folding.grasps import candidates
from tatamu.folding.ideal import FoldLine, Stack, crease_of, ideal_fold, stack
from tatamu.folding.pinch import outermost
from tatamu.folding.plan import Plan, Step
from tatamu.folding.plans import make_plan
from tatamu.folding.press import Press
from tatamu.garments import Garment
from tatamu.topology import Topology


@dataclass(frozen=True)
class Fold:
    """One fold of one garment."""

    garment: Garment
    start: np.ndarray
    """The cloth before the fold [m], shape (n, 3)."""
    line: np.ndarray
    """Two points of the fold line [m], shape (2, 2)."""
    crease: FoldLine
    """The fold line and its moving side."""
    stacks: Stack
    """Heights of the cloth before the fold."""
    target: np.ndarray
    """The target shape S_t [m], shape (n, 3)."""
    left: np.ndarray
    """Grasp candidates of the left hand, from the corner inwards, shape (M,)."""
    right: np.ndarray
    """Grasp candidates of the right hand, from the corner inwards, shape (M,); unused if one hand folds."""
    hands: int = 2
    area_ratio: float | None = None
    """Folded area over the area before, for a fold without thickness; None for the target's ratio."""
    fingers: Fingers = field(default_factory=Fingers)
    """Fingers of the hands."""
    press: Press | None = None
    """The press after the hands have left the fold; None if it is not pressed."""

    @property
    def normal(self) -> np.ndarray:
        """Unit vector across the line, from the moving side to the side that stays, shape (2,)."""
        return self.crease.normal

    @property
    def candidates(self) -> int:
        """M: the number of grasps that each hand may choose from."""
        return len(self.left)

    @cached_property
    def span(self) -> float:
        """Horizontal distance from grasp to release [m], mean of both hands, with the grasps nearest to the line."""
        nearest = [min(self.span_of(int(vertex)) for vertex in hand) for hand in (self.left, self.right)]
        return sum(nearest[: self.hands]) / self.hands

    def span_of(self, vertex: int) -> float:
        """Return the horizontal distance from a grasp to its release [m]."""
        return float(-2.0 * self.crease.split(self.start[[vertex]])[0][0])

    def translation(self, vertex: int) -> np.ndarray:
        """Return the vector from a grasp P0 to its release P3 [m], shape (3,); the fingers' `lift` raises both equally.

        P3 is the mirror image of P0, at the height at which the lowest layer in the hand touches the side that stays.
        With fingers, P3 is nearer and higher, because the layers go round the tip of the lower finger.
        """
        lowest = self.start[self.patch(vertex), 2].min() - 0.5 * self.garment.material.thickness
        rise = self.stacks.under[vertex] - lowest
        if self.fingers.stated:
            rise += self.held_thickness(vertex)
        return np.array([*(self.span_of(vertex) - self.fingers.setback) * self.normal, rise])

    def held_thickness(self, vertex: int) -> float:
        """Return the thickness of the layers that fingers hold in a pinch at a vertex [m]."""
        return float(np.ptp(self.start[self.patch(vertex), 2]) + self.garment.material.thickness)

    @cached_property
    def releases(self) -> tuple[np.ndarray, ...]:
        """Span, and height of the release over the grasp, of each hand's candidates [m], shape (M, 2)."""
        hands = (self.left, self.right)[: self.hands]
        return tuple(np.array([[self.span_of(int(v)), self.translation(int(v))[2]] for v in hand]) for hand in hands)

    def patch(self, vertex: int) -> list[int]:
        """Return the vertices that fingers hold in a pinch at a vertex: under the pad, the outermost of every layer."""
        if vertex not in self._patches:
            self._patches[vertex] = self._patch(vertex)
        return list(self._patches[vertex])

    @cached_property
    def _patches(self) -> dict[int, list[int]]:
        """Patches computed so far; a search uses the same few in every trial."""
        return {}

    def _patch(self, vertex: int) -> list[int]:
        spacing = self.garment.spacing
        across, along = self.crease.split(self.start)
        sideways = np.abs(along - along[vertex]) <= max(
            self.fingers.width / 2, 1.3 * spacing
        )  # On a coarse mesh also neighbours.
        inwards = np.abs(across - across[vertex]) <= PAD + 1e-9
        under = np.flatnonzero(sideways & inwards & (across < 0))
        held = outermost(across[under], along[under], self._links(under), spacing)
        return under[held | (under == vertex)].tolist()

    def _links(self, vertices: np.ndarray) -> np.ndarray:
        """Return the edges of the mesh between some vertices, by their indices in `vertices`, shape (e, 2)."""
        place = np.full(len(self.start), -1)
        place[vertices] = np.arange(len(vertices))
        links = place[self._edges]
        return np.asarray(links[(links >= 0).all(axis=1)])

    @cached_property
    def _edges(self) -> np.ndarray:
        return Topology(self.garment.faces).edges

    @property
    def crease_ends(self) -> tuple[float, float]:
        """The two ends of the cloth along the fold line [m]."""
        across, along = self.crease.split(self.start)
        near = along[np.abs(across) <= self.garment.spacing]
        return float(near.min()), float(near.max())

    @property
    def folded_thickness(self) -> float:
        """Thickness of the layers at the fold line after the fold, their loops pressed [m]."""
        near = np.abs(self.crease.split(self.start)[0]) <= self.garment.spacing
        return 2.0 * float(self.stacks.middle[near].max() + 0.5 * self.garment.material.thickness)

    def still(self) -> np.ndarray:
        """Return which vertices a perfect fold does not move, shape (n,)."""
        return np.linalg.norm(self.target - self.start, axis=1) < 1e-6


def fold_of(
    garment: Garment, plan: Plan, step: Step, state: np.ndarray | None = None, hands: int | None = None
) -> Fold:
    """Return the fold of a step of a plan.

    Args:
        garment: The garment to fold.
        plan: The plan that the step belongs to.
        step: The step to fold.
        state: The cloth as it lies [m], shape (n, 3); None if flat.
        hands: Number of hands that fold; None for the plan's number.

    Raises:
        InputError: If the garment cannot be folded by this step.
    """
    state = garment.vertices if state is None else state
    line = plan.line(step, garment)
    across, _ = line.split(state)
    if not (across.min() < 0 < across.max()):
        raise InputError(f"line: the fold line of step {step.title or step.line} does not cross the garment")
    _check_room(garment, -across.min())
    hands = hands or step.hands
    left, right = candidates(garment, state, line, step, hands)
    points = plan.points(step, garment)
    stacks = stack(garment, state, line)
    target = ideal_fold(garment, state, line, stacks)
    made = Fold(garment, state, points, line, stacks, target, left, right, hands, step.area_ratio, press=step.press)
    if step.press is not None:
        low, high = made.crease_ends
        step.press.gap_over(garment.material, made.folded_thickness, high - low)  # refuse a gap without room now
    return made


def _check_room(garment: Garment, reach: float) -> None:
    """Refuse a crease that is wider than the moving side."""
    width = crease_of(garment, garment.material.thickness).arc[-1]
    if width > reach:
        raise InputError(
            f"fold: a crease of this material takes {width:.3f} m on either side, but the side that moves is only "
            f"{reach:.3f} m wide; give a larger garment or a limper material"
        )


def make_fold(name: str, garment: Garment) -> Fold:
    """Return the first fold of a plan, given by its name, on the flat garment.

    Raises:
        InputError: If there is no such plan, or the garment cannot be folded by it.
    """
    plan = make_plan(name, garment)
    return fold_of(garment, plan, plan.steps[0])


def ideal_folds(garment: Garment, plan: Plan, hands: int | None = None) -> list[Fold]:
    """Return the folds of a plan, from the flat garment; each starts from the ideal result of the one before.

    Raises:
        InputError: If the garment cannot be folded by this plan.
    """
    folds: list[Fold] = []
    for step in plan.steps:
        folds.append(fold_of(garment, plan, step, folds[-1].target if folds else None, hands))
    return folds
