"""The jaws of a hand, and the geometry of the grasp. docs/theory/grasp.md has a drawing."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.folding.fingers import FingerSize

GAP = 0.001
"""Height at which the lower finger of the open jaw passes over the table [m]. It is less than the cloth's thickness."""
MIN_HELD = 0.005
"""Minimum depth of cloth between the closed fingertips [m]."""
HELD = 0.0005
"""Distance of each closed fingertip from the jaw's middle [m]: half the thickness of a thin cloth."""
Length = Annotated[float, Field(ge=0, le=0.2)]
Angle = Annotated[float, Field(ge=0, le=float(np.pi / 2))]


class Jaw(FingerSize):
    """Two fingers that open and close in parallel, one under and one over the edge of the cloth.

    The tool T is between the ends of the closed fingertips, z is the direction of approach, and the jaws open along y.
    """

    widest: Length = 0.05
    """Maximum opening of the jaw [m]."""
    force: Annotated[float, Field(gt=0, le=500)] = 20.0
    """Force with which the fingers grip the cloth [N]."""
    depth: Length = 0.011
    """Distance from the edge of the cloth to the place where the fingertips meet, at right angles to the edge [m]."""
    tilt: tuple[Angle, Angle] = (0.17, 1.05)
    """Smallest and largest angle from straight down to the direction of approach [rad]."""
    yaw: Angle = 1.05
    """Maximum rotation about the vertical, towards the other hand [rad]; 0 is at right angles to the edge."""
    fingers: dict[str, tuple[float, float]] = Field(default_factory=dict)
    """Joints that move the fingers, with their positions at the width `opening` and closed [rad, m]."""
    links: list[str] = Field(default_factory=list)
    """Links that are fingers, which may come closer to the table than other links."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.tilt[0] > self.tilt[1]:
            raise ValueError(f"tilt must be the minimum, then the maximum angle, given {list(self.tilt)}")
        if self.opening <= 2 * HELD:
            raise ValueError(f"opening must be more than {2 * HELD:g} m, given {self.opening:g}")
        return self

    def held(self, depth: float, height: float) -> float:
        """Return the depth of cloth between fingertips that meet at `depth` from the edge and at `height` [m].

        The cloth rises to the fingertips at 45 degrees, so it needs more length than cloth that lies flat.
        """
        return depth - (float(np.sqrt(2)) - 1) * height

    def takes_at(self, tilt: float) -> bool:
        """Return whether a closed jaw with this tilt [rad] has enough cloth between its fingertips."""
        return self.held(self.depth, self.height(tilt)) >= MIN_HELD

    def height(self, tilt: float) -> float:
        """Return the height of T above the table [m] at which the lower finger passes over it at the distance GAP."""
        return float(GAP + (self.opening / 2 + self.thickness) * np.sin(tilt))

    def prefixed(self, prefix: str) -> Jaw:
        """Return the same jaw for a model whose names have a prefix."""
        return self.model_copy(
            update={
                "fingers": {prefix + name: positions for name, positions in self.fingers.items()},
                "links": [prefix + name for name in self.links],
            }
        )
