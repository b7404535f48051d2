"""The gripper of an arm: how far it opens for a grasp, and how firmly it holds cloth."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from tatamu.records import Record

Width = Annotated[float, Field(ge=0, le=0.3)]
"""Between the fingertips [m]."""


class Gripper(Record):
    """Widths and force of a gripper's commands."""

    open: Width = 0.05
    """Width of the open hand, at which the robot's own software has its value for open [m]; plans open less far, to
    `Jaw.opening`."""
    closed: Width = 0.0
    """Width that is commanded to hold cloth [m]; the cloth stops the fingers before."""
    force: float = Field(20.0, gt=0, le=500)
    """Force with which it holds [N]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not self.closed < self.open:
            raise ValueError(f"closed must be less than open ({self.open:g} m), given {self.closed:g}")
        return self
