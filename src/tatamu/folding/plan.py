"""A fold plan: a sequence of folds, which users write as TOML (docs/reference/fold-plan.md)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
import tomli_w
from pydantic import BeforeValidator, Field, model_validator

from tatamu.base.errors import InputError
from tatamu.base.files import read_toml, validated
from tatamu.base.records import Record
from tatamu.folding.layout import FoldLine
from tatamu.folding.press import Press
from tatamu.garments import Garment

AUTO = "auto"
"""Name of the edge farthest from the fold line."""
SIDES = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0), "+y": (0.0, 1.0), "-y": (0.0, -1.0)}
"""Direction from the fold line to the side of the cloth that moves, by its name."""

Place = tuple[float, float]


def _names(value: object) -> object:
    return (value,) if isinstance(value, str) else value


class Step(Record):
    """One fold of a plan."""

    title: str = ""
    line: tuple[Place, Place]
    """Two points (x, y), in the plan's unit."""
    moves: Literal["+x", "-x", "+y", "-y"]
    grasp: Annotated[tuple[str, ...], BeforeValidator(_names), Field(min_length=1, max_length=2)] = (AUTO,)
    """Edge that both hands grasp, or the edges of the left and of the right hand."""
    hands: Literal[1, 2] = 2
    area_ratio: float | None = Field(None, gt=0.0, le=1.0)
    """Area after the fold divided by the area before, for cloth without thickness; None to use the target's."""

    press: Press | None = None
    """Pressing after the hands have left; None if the fold is not pressed."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        direction = np.subtract(self.line[1], self.line[0])
        if not np.hypot(*direction) > 1e-6:
            raise ValueError(f"line must have two different points, given {list(map(list, self.line))}")
        if abs(np.cross([*direction, 0.0], [*SIDES[self.moves], 0.0])[2]) < 1e-9:
            raise ValueError(
                f"moves must point across the fold line, given {self.moves} for a line along {self.moves[1]}"
            )
        return self


class Plan(Record):
    """A sequence of folds of a garment."""

    name: str = Field(min_length=1, max_length=60, pattern=r"^[\w -]+$")
    unit: Literal["fraction", "m"] = "fraction"
    """Unit of the fold lines, whose origin is the garment's middle: metres, or fractions of its length (x) and width
    (y)."""
    steps: Annotated[tuple[Step, ...], Field(min_length=1, max_length=20, alias="step")]

    def to_toml(self) -> str:
        steps = [step.model_dump(exclude_defaults=True, mode="json") for step in self.steps]
        return tomli_w.dumps({"plan": {"name": self.name, "unit": self.unit}, "step": steps})

    def points(self, step: Step, garment: Garment) -> np.ndarray:
        """Return two points of a step's fold line [m], shape (2, 2)."""
        scale = np.array([garment.size[1], garment.size[0]]) if self.unit == "fraction" else np.ones(2)
        return np.array(step.line) * scale

    def line(self, step: Step, garment: Garment) -> FoldLine:
        return line_of(self.points(step, garment), step.moves)


def line_of(points: np.ndarray, moves: str) -> FoldLine:
    """Return the fold line through two points [m], shape (2, 2), whose moving side is in the direction `moves`."""
    direction = (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
    normal = np.array([direction[1], -direction[0]])
    normal = np.where(normal == 0.0, 0.0, normal)  # no negative zero
    normal = normal if normal @ SIDES[moves] < 0 else -normal
    return FoldLine(origin=(points[0] @ normal) * normal, normal=normal)


def load_plan(path: Path) -> Plan:
    """Read a plan from TOML. Errors name the file and the field."""
    value = read_toml(path)
    head = value.pop("plan", {})
    if not isinstance(head, dict):
        raise InputError(f"{path}: plan: must be a table [plan], given {head!r}")
    return validated(Plan, {"name": path.stem, **head, **value}, path)
