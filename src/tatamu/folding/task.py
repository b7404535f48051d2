"""A task: one step of a fold plan, which is one fold of one garment, in one simulator, perhaps for one robot."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.records import OpenRecord
from tatamu.folding.aim import Aim
from tatamu.folding.fingers import Fingers
from tatamu.folding.fold import Fold, fold_of, ideal_folds
from tatamu.folding.manipulation import HandShift, Manipulation, bezier_manipulation, shifted
from tatamu.folding.parameters import search_space
from tatamu.folding.plan import Plan
from tatamu.folding.plans import make_plan
from tatamu.garments import Garment, make_garment
from tatamu.search.space import Space
from tatamu.simulation.material import Material
from tatamu.simulation.simulators import capabilities


def _no_refusal(manipulation: Manipulation) -> None:
    """Return None: the default of `Reach.refusal`, not a lambda because those cannot be pickled."""


@dataclass(frozen=True)
class Reach:
    """Which manipulations a robot can execute. Answers depend on the manipulation alone."""

    robot: str
    description: bytes = field(default=b"", kw_only=True)
    """Content of the file that describes the robot; empty for a built-in one."""
    files: tuple[Path, ...] = field(default=(), kw_only=True)
    """The file that describes the robot, and those to which it refers."""
    disturbances: Mapping[str, Any] | None = field(default=None, kw_only=True)
    """Table of disturbances in the robot's description; None if there is none."""
    quality: Callable[[Manipulation], float]
    """Rates the robot's motion along a manipulation on Bezier curves, negative if it cannot execute it."""
    refusal: Callable[[Manipulation], str | None] = _no_refusal
    """Returns why the robot cannot execute a manipulation, or None."""


class TaskOptions(OpenRecord):
    """The options of a task as the user gave them, such as the name of the garment; None for the defaults."""

    garment: str
    fold: str
    size: list[float] | None = None
    """Width and length [m]."""
    spacing: float | None = None
    """Distance between neighbouring vertices of the mesh [m]."""
    scale: float | None = None
    """Metres per unit of the garment's file."""
    hands: int | None = None
    material: str | None = None
    """Name or file."""
    robot: str | None = None

    UNSAID: ClassVar[frozenset[str]] = frozenset({"scale", "material", "robot"})


@dataclass(frozen=True, eq=False)
class Task:
    """One step of a fold plan for one garment, in one simulator."""

    garment: Garment
    plan: Plan
    simulator: str
    hands: int | None = None
    """Number of hands; None for the plan's."""
    reach: Reach | None = None
    """Which manipulations the robot can execute; None for all."""
    asked: TaskOptions | None = None
    """The names and options from which the task was made; None if it was made from objects."""
    fingers: Fingers = field(default_factory=Fingers)
    number: int = 0
    """Index of the step in the plan."""
    state: np.ndarray | None = None
    """The cloth before the fold [m], shape (n, 3); None if it lies flat."""
    aim: Aim = field(default_factory=Aim)
    softening: float = 1.0
    shift: tuple[HandShift, ...] = ()
    """Correction of each hand's path, left before right; empty for none."""

    def __repr__(self) -> str:
        number, count = self.step
        return f"<Task: {self.garment!r}, fold {self.plan.name}, step {number} of {count}, simulator {self.simulator}>"

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling, without the robot, which only the process that proposes trials needs."""
        return {**self.__dict__, "reach": None}

    @cached_property
    def fold(self) -> Fold:
        made = fold_of(self.garment, self.plan, self.plan.steps[self.number], self.state, self.hands)
        return replace(made, fingers=self.fingers, aim=self.aim, softening=self.softening)

    @cached_property
    def space(self) -> Space:
        """The search space of x = (x1, z1, x2, z2, g1, g2), Eq. (9), with whole grasps."""
        return search_space(self.fold)

    @property
    def step(self) -> tuple[int, int]:
        """Number of the step, counted from 1, and number of steps."""
        return self.number + 1, len(self.plan.steps)

    @property
    def title(self) -> str:
        return self.plan.steps[self.number].title

    def at(self, number: int, state: np.ndarray | None) -> Task:
        """Return the task for another step, by its index, from cloth at `state` [m], shape (n, 3), or flat cloth."""
        return replace(self, number=number, state=state)

    def next(self, state: np.ndarray) -> Task:
        """Return the task for the next step, from the cloth after this one [m], shape (n, 3)."""
        if self.number + 1 == len(self.plan.steps):
            raise InputError(
                f"task: has no next step, because step {self.number + 1} is the last of fold plan {self.plan.name}"
            )
        return self.at(self.number + 1, state)

    def manipulation(self, parameters: Mapping[str, float]) -> Manipulation:
        """Return the manipulation with the parameters (x1, z1, x2, z2, g1, g2), Eq. (9). Grasps are rounded down."""
        check_parameters(parameters, self.fold.candidates)
        g1, g2 = (min(int(parameters[name]), self.fold.candidates - 1) for name in ("g1", "g2"))
        grasps = (int(self.fold.left[g1]), int(self.fold.right[g2]))[: self.fold.hands]
        made = bezier_manipulation(self.fold, grasps, *(parameters[name] for name in ("x1", "z1", "x2", "z2")))
        return shifted(self.fold, made, self.shift) if self.shift else made


def check_parameters(parameters: Mapping[str, float], candidates: int) -> None:
    """Check the parameters x1, z1, x2, z2 [m], g1 and g2 of Eq. (9) of a hand with so many grasp candidates.

    Raises:
        InputError: If a parameter is missing, not finite, a negative height, or no grasp. The message names it.
    """
    for name in ("x1", "z1", "x2", "z2", "g1", "g2"):
        value = parameters.get(name)
        if not isinstance(value, int | float | np.integer | np.floating) or not isfinite(value):
            raise InputError(f"{name}: must be a finite number, given {value!r}")
        if name.startswith("z") and value < 0.0:
            raise InputError(f"{name}: must be a height of at least 0 m, given {value:g}")
        if name.startswith("g") and not 0 <= value <= candidates:
            raise InputError(f"{name}: must be the index of a grasp, 0 to {candidates - 1}, given {value:g}")


def make_task(
    garment: Garment | str | Path,
    *,
    fold: str = "half",
    size: tuple[float, float] | None = None,
    material: Material | Path | str | None = None,
    spacing: float | None = None,
    scale: float | None = None,
    simulator: str = "native",
    hands: int | None = None,
    reach: Reach | None = None,
    fingers: Fingers | None = None,
) -> Task:
    """Return the task for the first step of a fold plan, which is named, proposed (`auto`) or a file.

    `size`, `material`, `spacing` and `scale` are for a garment that is given by its name or file; None stands for its
    own. Lengths are in metres, and `scale` in metres per unit of the file. Errors name the argument.
    """
    coarse = capabilities(simulator).coarse_search
    if hands not in (None, 1, 2):
        raise InputError(f"hands: must be 1 or 2, given {hands}")
    if isinstance(garment, Garment):
        if (size, material, spacing, scale) != (None, None, None, None):
            raise InputError(
                "size, material, spacing, scale: must be left out if garment is a Garment; give these values to "
                "make_garment"
            )
        made = garment
    else:
        made = make_garment(str(garment), size, material, spacing, scale)
    plan = make_plan(fold, made)
    ideal_folds(made, plan, hands)  # raises an error now if a later step cannot be folded
    garment, softening = learning_mesh(made, plan, hands) if coarse else (made, 1.0)
    asked = _asked(made, fold, hands, reach)
    return Task(garment, plan, simulator, hands, reach, asked, fingers or Fingers(), softening=softening)


def learning_mesh(garment: Garment, plan: Plan, hands: int | None) -> tuple[Garment, float]:
    """Return a garment on the mesh on which it is folded, and the divisor k^2 of its stretch stiffness.

    Large triangles lock: where cloth curves in two directions, they must stretch instead of bend, and the cloth seems
    too stiff. The effect depends on Y h^2 / B, with the stretch stiffness Y, the spacing h and the bending rigidity B.
    On a mesh whose spacing is k times the garment's own, scenes therefore have the stretch stiffness Y / k^2.

    The ratios k are the largest for which a fold succeeds on this mesh as it does on a mesh of half the spacing, in
    nearly all scenarios (`python -m benchmarks.scenarios`, docs/notes/margins.md). A garment keeps its mesh if its
    spacing was given, if `make_garment` did not make it, and if it is small.
    """
    source = garment.source
    if source is None or garment.spacing_given:
        return garment, 1.0
    ratio = 1.5 if len(plan.steps) > 1 else 2.0 if garment.layers == 1 else 1.7  # loops of earlier steps spring open
    try:
        made = make_garment(source.name, source.size, garment.material, ratio * garment.spacing, source.scale)
        ideal_folds(made, plan, hands)
    except InputError:
        return garment, 1.0
    if not 250 <= len(made.vertices) < len(garment.vertices):
        return garment, 1.0
    return replace(made, source=source), ratio**2


def _asked(garment: Garment, fold: str, hands: int | None, reach: Reach | None) -> TaskOptions | None:
    """Return the names and options of a task; None if its garment was not made by `make_garment`."""
    source = garment.source
    if source is None:
        return None
    return TaskOptions(
        garment=source.name,
        fold=fold,
        size=list(source.size) if source.size else None,
        spacing=source.spacing,
        scale=source.scale,
        hands=hands,
        material=source.material,
        robot=str(reach.files[0]) if reach and reach.files else None,
    )


def digest(*arrays: np.ndarray) -> str:
    """Return a short name for arrays, which changes with any bit of them."""
    return sha256(b"".join(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in arrays)).hexdigest()[:16]


def check_reach(task: Task) -> None:
    """Raise InputError if the robot can carry out no typical fold in a step of the plan."""
    if task.reach is None:
        return
    folds = ideal_folds(task.garment, task.plan, task.hands)
    for number in range(task.number, len(folds)):
        _check_step(task.at(number, folds[number - 1].target if number else None), task.reach)


def _check_step(task: Task, reach: Reach) -> None:
    number, count = task.step
    name = f"step {number}, {task.title}" if count > 1 else f"the fold {task.title or task.plan.name}"
    if task.fold.press is not None:
        raise InputError(f"press: {reach.robot} cannot press {name}; leave press out of the fold plan")
    refusals = []
    for parameters in _typical_folds(task.fold):
        refusal = reach.refusal(task.manipulation(parameters))
        if refusal is None:
            return
        refusals.append(refusal)
    raise InputError(
        f"robot: must be able to carry out {name}, but {reach.robot} fails in all {len(refusals)} attempts; "
        f"the first fails because {refusals[0]}"
    )


def _typical_folds(fold: Fold) -> Iterator[dict[str, float]]:
    last = fold.candidates - 1
    for grasp in dict.fromkeys((0, last // 2, last)):
        for up in (0.2 * fold.span, 0.5 * fold.span):
            yield {"x1": 0.1 * fold.span, "z1": up, "x2": 0.8 * fold.span, "z2": up, "g1": grasp, "g2": grasp}
