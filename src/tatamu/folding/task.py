"""A task: one step of a fold plan, which is one fold of one garment, in one simulator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
from tatamu.folding.manipulation import Manipulation, bezier_manipulation
from tatamu.folding.mesh import learning_mesh
from tatamu.folding.parameters import search_space
from tatamu.folding.plan import Plan
from tatamu.folding.plans import make_plan
from tatamu.folding.shift import HandShift, shifted
from tatamu.garments import Garment, make_garment
from tatamu.search.space import Space
from tatamu.simulation.material import Material
from tatamu.simulation.simulators import capabilities


def _no_refusal(manipulation: Manipulation) -> None:
    """Return None, which means that a robot can execute any manipulation.

    It is the default of `Reach.refusal`. It is not a lambda, because a lambda cannot be pickled.
    """


def _forget_nothing() -> None:
    """Do nothing. This is the default of `Reach.forget`, for robots without stored placements."""


@dataclass(frozen=True)
class Reach:
    """Describes which manipulations a robot can execute."""

    robot: str
    """Name of the robot."""
    description: bytes = field(default=b"", kw_only=True)
    """Content of the file that describes the robot; empty for a robot that tatamu contains."""
    files: tuple[Path, ...] = field(default=(), kw_only=True)
    """The file that describes the robot, and the files to which it refers."""
    disturbances: Mapping[str, Any] | None = field(default=None, kw_only=True)
    """Table of disturbances in the robot's description; None if the description has no such table."""
    quality: Callable[[Manipulation], float]
    """Function that rates the robot's motion along a manipulation on Bezier curves.

    The rating is negative if the robot cannot execute the manipulation."""
    refusal: Callable[[Manipulation], str | None] = _no_refusal
    """Function that returns why the robot cannot execute a manipulation; None if the robot can.

    A call does not change later results of `quality`."""
    forget: Callable[[], None] = _forget_nothing
    """Function that deletes the placements of the robot (where it stands) that `quality` has stored."""


class TaskOptions(OpenRecord):
    """The options of a task, exactly as the user gave them, such as the names of the garment and the fold."""

    garment: str
    fold: str
    size: list[float] | None = None
    """Width and length of the garment [m]; None for the garment's own size."""
    spacing: float | None = None
    """Distance between neighbouring vertices of the mesh [m]; None for the garment's own spacing."""
    scale: float | None = None
    """Metres per unit of the garment's file; None if the file states its unit."""
    hands: int | None = None
    """Number of hands that fold; None for the number in the plan."""
    material: str | None = None
    """Name or file of the cloth's material; None for the garment's own material."""
    robot: str | None = None
    """Name or file of the robot that must be able to execute the fold; None if any manipulation is allowed."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"scale", "material", "robot"})

    @property
    def size_pair(self) -> tuple[float, float] | None:
        """Width and length of the garment [m]; None for the garment's own size."""
        return None if self.size is None else (self.size[0], self.size[1])


@dataclass(frozen=True, eq=False)
class Task:
    """One step of a fold plan for one garment, in one simulator."""

    garment: Garment
    plan: Plan
    simulator: str
    hands: int | None = None
    """Number of hands that fold; None for the number in the plan."""
    reach: Reach | None = None
    """Describes which manipulations the robot can execute; None if any manipulation is allowed."""
    asked: TaskOptions | None = None
    """The names and options from which the task was made; None if the task was made from objects."""
    fingers: Fingers = field(default_factory=Fingers)
    """The fingers of the hands."""
    number: int = 0
    """Number of the step in the fold plan, counted from 0."""
    state: np.ndarray | None = None
    """Positions of the cloth before the fold [m], shape (n, 3); None if the cloth lies flat."""
    aim: Aim = field(default_factory=Aim)
    """Room that the hands leave for errors."""
    softening: float = 1.0
    """Divisor of the stretch stiffness in scenes, because large triangles lock (`tatamu.folding.mesh`)."""
    shift: tuple[HandShift, ...] = ()
    """Correction of each hand's path, left before right; empty if no correction is needed."""

    def __repr__(self) -> str:
        number, count = self.step
        return f"<Task: {self.garment!r}, fold {self.plan.name}, step {number} of {count}, simulator {self.simulator}>"

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling, without the robot.

        Only the process that proposes trials needs the robot.
        """
        return {**self.__dict__, "reach": None}

    @cached_property
    def fold(self) -> Fold:
        """The fold of this step, with its fold line, target shape and grasp candidates."""
        made = fold_of(self.garment, self.plan, self.plan.steps[self.number], self.state, self.hands)
        return replace(made, fingers=self.fingers, aim=self.aim, softening=self.softening)

    @cached_property
    def space(self) -> Space:
        """The search space of the parameters x = (x1, z1, x2, z2, g1, g2), Eq. (9). Grasps are whole numbers."""
        return search_space(self.fold)

    @property
    def step(self) -> tuple[int, int]:
        """Number of the step, counted from 1, and number of steps in the plan."""
        return self.number + 1, len(self.plan.steps)

    @property
    def title(self) -> str:
        """Title of the fold, in a few words."""
        return self.plan.steps[self.number].title

    def at(self, number: int, state: np.ndarray | None) -> Task:
        """Return the task for another step of the same fold plan.

        Args:
            number: Number of the step, from 0.
            state: Positions of the cloth before that step [m], shape (n, 3); None if the cloth lies flat.
        """
        return replace(self, number=number, state=state)

    def next(self, state: np.ndarray) -> Task:
        """Return the task for the next step of the fold plan.

        Args:
            state: Positions of the cloth after this step [m], shape (n, 3).

        Raises:
            InputError: If this is the last step.
        """
        if self.number + 1 == len(self.plan.steps):
            raise InputError(f"task: must have a next step, and {self.plan.name} ends with step {self.number + 1}")
        return self.at(self.number + 1, state)

    def manipulation(self, parameters: Mapping[str, float]) -> Manipulation:
        """Return the manipulation with the parameters x = (x1, z1, x2, z2, g1, g2), Eq. (9).

        Grasps that are not whole numbers are rounded down.

        Raises:
            InputError: If a parameter is missing, not finite, a negative height, or not the number of a grasp. The
                message names the parameter.
        """
        check_parameters(parameters, self.fold.candidates)
        g1, g2 = (min(int(parameters[name]), self.fold.candidates - 1) for name in ("g1", "g2"))
        grasps = (int(self.fold.left[g1]), int(self.fold.right[g2]))[: self.fold.hands]
        made = bezier_manipulation(self.fold, grasps, *(parameters[name] for name in ("x1", "z1", "x2", "z2")))
        return shifted(self.fold, made, self.shift) if self.shift else made


def check_parameters(parameters: Mapping[str, float], candidates: int) -> None:
    """Raise an error for parameters that no manipulation can have.

    Args:
        parameters: The parameters x1, z1, x2, z2 [m], g1 and g2 of Eq. (9).
        candidates: Number of grasps from which each hand may choose.

    Raises:
        InputError: If a parameter is missing, not finite, a negative height, or not the number of a grasp. The message
            names the parameter.
    """
    for name in ("x1", "z1", "x2", "z2", "g1", "g2"):
        value = parameters.get(name)
        if not isinstance(value, int | float | np.integer | np.floating) or not isfinite(value):
            raise InputError(f"{name}: must be a finite number, given {value!r}")
        if name.startswith("z") and value < 0.0:
            raise InputError(f"{name}: must be a height of 0 or more [m], given {value:g}")
        if name.startswith("g") and not 0 <= value <= candidates:
            raise InputError(f"{name}: must be a grasp from 0 to {candidates - 1}, given {value:g}")


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
    """Return the task for the first step of a fold plan.

    Args:
        garment: A garment, the name of a garment, or its file. The arguments `size`, `material`, `spacing` and `scale`
            only apply to a name or a file.
        fold: Name of a fold plan, or its file.
        size: Width and length of the garment [m]; None for the garment's own size.
        material: Material of the cloth, the name of a preset, or a file; None for the garment's own material.
        spacing: Distance between neighbouring vertices [m]; None for the garment's own spacing.
        scale: Metres per unit of the garment's file; None if the file states its unit.
        simulator: Name of the simulator.
        hands: Number of hands that fold, 1 or 2; None for the number in the plan.
        reach: Describes which manipulations the robot can execute; None if any manipulation is allowed.
        fingers: The fingers of the hands; None for hands without fingers.

    Raises:
        InputError: If a name is unknown, the garment cannot be made, or the plan cannot fold the garment. The message
            names the argument.
    """
    coarse = capabilities(simulator).coarse_search
    if hands not in (None, 1, 2):
        raise InputError(f"hands: must be 1 or 2, given {hands}")
    if isinstance(garment, Garment):
        if (size, material, spacing, scale) != (None, None, None, None):
            raise InputError("garment: has its size, material, spacing and scale; give them to make_garment")
        made = garment
    else:
        made = make_garment(str(garment), size, material, spacing, scale)
    plan = make_plan(fold, made)
    ideal_folds(made, plan, hands)  # raises an error now if a later step cannot be folded
    garment, softening = learning_mesh(made, plan, hands) if coarse else (made, 1.0)
    asked = _asked(made, fold, hands, reach)
    return Task(garment, plan, simulator, hands, reach, asked, fingers or Fingers(), softening=softening)


def _asked(garment: Garment, fold: str, hands: int | None, reach: Reach | None) -> TaskOptions | None:
    """Return the names and options, as the user gave them, from which a task was made.

    The result is None if the garment was not made by `make_garment`.
    """
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
    """Return a short name for arrays of numbers. The name changes if any bit of the arrays changes."""
    return sha256(b"".join(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in arrays)).hexdigest()[:16]
