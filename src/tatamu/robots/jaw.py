"""The jaw of a hand, and the geometry of the grasp. docs/theory/grasp.md has a drawing.

The tool T is the point between the ends of the closed fingertips. Its z is the direction of approach, and the jaw opens
along its y. One finger goes under the edge of the cloth, the other finger goes over it. The fingertips meet at the
distance `depth` from the edge, measured at right angles to the edge.
"""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.folding.fingers import FingerSize

GAP = 0.001
"""Height at which the lower finger of the open jaw passes over the table [m]. It is less than the cloth's thickness."""
LEAST_HELD = 0.005
"""Smallest depth of cloth between the closed fingertips [m]."""
HELD = 0.0005
"""Distance of each closed fingertip from the jaw's middle [m]: half the thickness of a thin cloth."""
Length = Annotated[float, Field(ge=0, le=0.2)]
Angle = Annotated[float, Field(ge=0, le=float(np.pi / 2))]


class Jaw(FingerSize):
    """A jaw with two fingers that open and close in parallel, and the way in which they grasp the edge of the cloth."""

    widest: Length = 0.05
    """Largest opening of the jaw [m]."""
    force: Annotated[float, Field(gt=0, le=500)] = 20.0
    """Force with which the fingers grip the cloth [N]."""
    depth: Length = 0.011
    """Distance from the edge of the cloth to the place where the fingertips meet, at right angles to the edge [m]."""
    tilt: tuple[Angle, Angle] = (0.17, 1.05)
    """Smallest and largest angle from straight down to the direction of approach [rad]."""
    yaw: Angle = 1.05
    """Largest allowed rotation of the jaw about the vertical, towards the other hand [rad].

    At the angle 0, the jaw's plane is at right angles to the edge of the cloth.
    """
    fingers: dict[str, tuple[float, float]] = Field(default_factory=dict)
    """Joints of the model that move the fingers.

    Each joint has its positions when the jaw has the width `opening` and when it is closed [rad, m].
    """
    links: list[str] = Field(default_factory=list)
    """Links of the model whose shapes are the fingers.

    They may come nearer to the table than the other links of the arm.
    """

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.tilt[0] > self.tilt[1]:
            raise ValueError(f"tilt must be the least, then the greatest angle, given {list(self.tilt)}")
        if self.opening <= 2 * HELD:
            raise ValueError(f"opening must be more than {2 * HELD:g} m, given {self.opening:g}")
        return self

    def held(self, depth: float, height: float) -> float:
        """Return the depth of cloth between the closed fingertips [m].

        The fingertips meet at the distance `depth` from the edge of the cloth and at `height` above the table [m]. The
        cloth rises to the fingertips at 45 degrees. It therefore needs more length than cloth that lies flat.
        """
        return depth - (float(np.sqrt(2)) - 1) * height

    def takes_at(self, tilt: float) -> bool:
        """Return whether a closed jaw with this tilt [rad] has enough cloth between its fingertips."""
        return self.held(self.depth, self.height(tilt)) >= LEAST_HELD

    def height(self, tilt: float) -> float:
        """Return the height of the tool T above the table [m] for a jaw with this tilt [rad].

        At this height, the lower finger of the open jaw passes over the table at the distance GAP.
        """
        return float(GAP + (self.opening / 2 + self.thickness) * np.sin(tilt))

    def prefixed(self, prefix: str) -> Jaw:
        """Return the same jaw for a model whose names have a prefix."""
        return self.model_copy(
            update={
                "fingers": {prefix + name: positions for name, positions in self.fingers.items()},
                "links": [prefix + name for name in self.links],
            }
        )
