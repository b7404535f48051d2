"""The jaw of a hand, and the geometry of taking a hem. docs/theory/grasp.md has a drawing.

T is the tool: the point between the ends of the closed fingertips, z the direction of approach, y the jaw's opening.
One finger goes under the hem, the other over it. The ends meet `depth` beyond the hem's edge, across the hem.
"""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.folding.fingers import FingerSize

GAP = 0.001
"""Height at which the lower finger of the open jaw passes over the table [m]; it is less than the cloth's thickness."""
LEAST_HELD = 0.005
"""Least depth of cloth between the closed fingertips [m]."""
HELD = 0.0005
"""Distance of each closed fingertip from the jaw's middle [m]: half of a thin cloth."""
Length = Annotated[float, Field(ge=0, le=0.2)]
Angle = Annotated[float, Field(ge=0, le=float(np.pi / 2))]


class Jaw(FingerSize):
    """Two fingers that open and close in parallel, and how they take a hem."""

    widest: Length = 0.05
    """The farthest that the hand opens [m]."""
    force: Annotated[float, Field(gt=0, le=500)] = 20.0
    """Force with which the fingers hold cloth [N]."""
    depth: Length = 0.011
    """Distance beyond the hem's edge at which the fingertips meet, across the hem [m]."""
    tilt: tuple[Angle, Angle] = (0.17, 1.05)
    """Smallest and largest angle of the approach from straight down [rad]."""
    yaw: Angle = 1.05
    """Greatest turn of the jaw's plane from the plane across the hem, towards the other hand [rad]."""
    fingers: dict[str, tuple[float, float]] = Field(default_factory=dict)
    """Joints of the model that move the fingers: their positions at `opening` and when closed [rad, m]."""
    links: list[str] = Field(default_factory=list)
    """Links of the model whose shapes are the fingers, which may come nearer to the table than the rest of the arm."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.tilt[0] > self.tilt[1]:
            raise ValueError(f"tilt must be the least, then the greatest angle, given {list(self.tilt)}")
        if self.opening <= 2 * HELD:
            raise ValueError(f"opening must be more than {2 * HELD:g} m, given {self.opening:g}")
        return self

    def held(self, depth: float, height: float) -> float:
        """Return the depth of cloth between the closed fingertips [m].

        The fingertips meet `depth` beyond the hem and `height` over the table [m]. The cloth rises to them at 45
        degrees, which takes more length than cloth that lies flat.
        """
        return depth - (float(np.sqrt(2)) - 1) * height

    def takes_at(self, tilt: float) -> bool:
        """Whether enough cloth is between the fingertips of a jaw of this tilt."""
        return self.held(self.depth, self.height(tilt)) >= LEAST_HELD

    def height(self, tilt: float) -> float:
        """Height of T above the table, at which the lower finger of the open jaw passes at GAP [m]."""
        return float(GAP + (self.opening / 2 + self.thickness) * np.sin(tilt))

    def prefixed(self, prefix: str) -> Jaw:
        """Return the same jaw for a model whose names have a prefix."""
        return self.model_copy(
            update={
                "fingers": {prefix + name: positions for name, positions in self.fingers.items()},
                "links": [prefix + name for name in self.links],
            }
        )
