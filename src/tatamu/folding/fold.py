"""One fold of a garment that lies on the table: the line, the target shape, and the vertices where hands may grasp."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.aim import Aim
from tatamu.folding.fingers import PAD, Fingers
from tatamu.folding.grasps import candidates, links_within, outermost
from tatamu.folding.ideal import Stack, crease_of, ideal_fold, stack
from tatamu.folding.layout import FoldLine, Layout
from tatamu.folding.plan import Plan, Step
from tatamu.folding.plans import make_plan
from tatamu.folding.press import Press
from tatamu.garments import Garment
from tatamu.simulation.mesh.topology import Topology


@dataclass(frozen=True)
class Fold:
    """One fold of one garment: where it starts, its fold line, and the shape that it should reach."""

    garment: Garment
    start: np.ndarray
    """The cloth before the fold [m], shape (n, 3)."""
    line: np.ndarray
    """Two points of the fold line [m], shape (2, 2)."""
    crease: FoldLine
    stacks: Stack
    target: np.ndarray
    """The target shape S_t: position of each vertex after a perfect fold [m], shape (n, 3)."""
    left: np.ndarray
    """The M vertices that the left hand may grasp, from the garment's corner inwards, shape (M,)."""
    right: np.ndarray
    """The same for the right hand, shape (M,). They are not used if one hand folds."""
    hands: int = 2
    area_ratio: float | None = None
    fingers: Fingers = field(default_factory=Fingers)
    aim: Aim = field(default_factory=Aim)
    softening: float = 1.0
    """Divisor of the stretch stiffness in scenes, because large triangles lock (`learning_mesh` of `task`)."""
    press: Press | None = None

    def __repr__(self) -> str:
        hands = "one hand" if self.hands == 1 else "two hands"
        return f"<Fold of {self.garment.name}: {hands}, {self.candidates} grasp candidates for each>"

    @property
    def normal(self) -> np.ndarray:
        return self.crease.normal

    @property
    def candidates(self) -> int:
        """How many grasps M each hand can choose from."""
        return len(self.left)

    @cached_property
    def span(self) -> float:
        """Horizontal distance from the grasp nearest to the fold line to its release [m], mean over the hands."""
        nearest = [min(self.span_of(int(vertex)) for vertex in hand) for hand in (self.left, self.right)]
        return sum(nearest[: self.hands]) / self.hands

    def vector(self, forward: float, left: float = 0.0, up: float = 0.0) -> np.ndarray:
        """Return a vector [m], shape (3,), from its parts in the fold's direction, to the left of it, and up."""
        return np.array([*(forward * self.normal + left * self.crease.along), up])

    def place(self, vertex: int) -> np.ndarray:
        """Return the place at which a hand aims to grasp a vertex [m], shape (3,)."""
        low, high = self._ends
        along = float(self.crease.split(self.start[[vertex]])[1][0])
        room = min(self.aim.from_end, 0.5 * (high - low))
        aside = min(max(along, low + room), high - room) - along
        return np.asarray(self.start[vertex] + self.vector(self.aim.into, aside, self.aim.height))

    @cached_property
    def _ends(self) -> tuple[float, float]:
        _, along = self.crease.split(self.start[np.concatenate([self.left, self.right])])
        return float(along.min()), float(along.max())

    def span_of(self, vertex: int) -> float:
        """Return the horizontal distance from a grasp to its release, its mirror image over the fold line [m]."""
        return float(-2.0 * self.crease.split(self.place(vertex)[None])[0][0])

    def translation(self, vertex: int) -> np.ndarray:
        """Return the vector from a grasp P0 to its release P3 [m], shape (3,), without the fingers' `lift`.

        P3 is the mirror image of P0 over the fold line, as high as the lowest layer in the hand touches the cloth that
        stays. With fingers it is nearer to P0 and higher, because the layers go round the tip of the lower finger.
        """
        lowest = self.start[self.patch(vertex), 2].min() - 0.5 * self.garment.material.thickness
        rise = self.stacks.under[vertex] - lowest
        if self.fingers.stated:
            rise += self.held_thickness(vertex)
        return np.array([*(self.span_of(vertex) - self.fingers.setback) * self.normal, rise])

    def held_thickness(self, vertex: int) -> float:
        """Return the thickness of the layers that fingers hold at a vertex [m]."""
        return float(np.ptp(self.start[self.patch(vertex), 2]) + self.garment.material.thickness)

    @cached_property
    def releases(self) -> tuple[np.ndarray, ...]:
        """Horizontal distance and height of the release from each of the M grasps [m], shape (M, 2) for each hand."""
        hands = (self.left, self.right)[: self.hands]
        return tuple(np.array([[self.span_of(int(v)), self.translation(int(v))[2]] for v in hand]) for hand in hands)

    def patch(self, vertex: int) -> list[int]:
        """Return the vertices that fingers hold at a vertex: the outermost ones of every layer under their pads."""
        if vertex in self._patches:
            return list(self._patches[vertex])
        spacing = self.garment.spacing
        across, along = self.crease.split(self.start)
        wide = max(self.fingers.width / 2, 1.3 * spacing)  # at least the neighbours of the vertex
        sideways = np.abs(along - along[vertex]) <= wide
        inwards = np.abs(across - across[vertex]) <= PAD + 1e-9
        under = np.flatnonzero(sideways & inwards & (across < 0))
        links = links_within(self._edges, under, len(self.start))
        held = outermost(across[under], along[under], links, spacing)
        self._patches[vertex] = under[held | (under == vertex)].tolist()
        return list(self._patches[vertex])

    @cached_property
    def _patches(self) -> dict[int, list[int]]:
        """Held vertices of each vertex that was grasped so far. All trials use the same few grasps."""
        return {}

    @cached_property
    def _edges(self) -> np.ndarray:
        return Topology(self.garment.faces).edges

    @property
    def crease_ends(self) -> tuple[float, float]:
        """Coordinates of both ends of the crease along the fold line, the smaller one first [m]."""
        across, along = self.crease.split(self.start)
        near = along[np.abs(across) <= self.garment.spacing]
        return float(near.min()), float(near.max())

    @property
    def folded_thickness(self) -> float:
        """Thickness of all layers at the fold line after the fold, with earlier loops pressed flat [m]."""
        near = np.abs(self.crease.split(self.start)[0]) <= self.garment.spacing
        return 2.0 * float(self.stacks.middle[near].max() + 0.5 * self.garment.material.thickness)

    def still(self) -> np.ndarray:
        """Return which vertices stay in place if the fold is perfect, shape (n,)."""
        return np.linalg.norm(self.target - self.start, axis=1) < 1e-6


def fold_of(
    garment: Garment, plan: Plan, step: Step, state: np.ndarray | None = None, hands: int | None = None
) -> Fold:
    """Return the fold that a step of a plan makes, from the cloth at `state` [m], shape (n, 3), or from flat cloth.

    Raises:
        InputError: If the garment cannot be folded by this step.
    """
    state = garment.vertices if state is None else state
    layout = Layout(garment, state, plan.line(step, garment))
    across, _ = layout.split()
    if not (across.min() < 0 < across.max()):
        raise InputError(f"line: must cross the garment, but the line of step {step.title or step.line} does not")
    width = crease_of(garment, garment.material.thickness).arc[-1]
    if width > -across.min():
        raise InputError(
            f"fold: the moving side must be at least {width:.3f} m wide for a crease of this material, given "
            f"{-across.min():.3f} m; give a larger garment or a more flexible material"
        )
    hands = hands or step.hands
    left, right = candidates(layout, step.grasp, hands)
    stacks = stack(layout)
    target = ideal_fold(layout, stacks)
    made = Fold(
        garment,
        state,
        plan.points(step, garment),
        layout.line,
        stacks,
        target,
        left,
        right,
        hands,
        step.area_ratio,
        press=step.press,
    )
    if step.press is not None:
        low, high = made.crease_ends
        step.press.gap_over(garment.material, made.folded_thickness, high - low)  # an early error if it is too low
    return made


def make_fold(name: str, garment: Garment) -> Fold:
    """Return the first fold of a named plan on the flat garment."""
    plan = make_plan(name, garment)
    return fold_of(garment, plan, plan.steps[0])


def ideal_folds(garment: Garment, plan: Plan, hands: int | None = None) -> list[Fold]:
    """Return all folds of a plan, each from the ideal result of the one before. Errors name the step."""
    folds: list[Fold] = []
    for number, step in enumerate(plan.steps, start=1):
        try:
            folds.append(fold_of(garment, plan, step, folds[-1].target if folds else None, hands))
        except InputError as error:
            title = f" ({step.title})" if step.title else ""
            raise InputError(f"{plan.name}: step {number}{title}: {error}") from None
    return folds
