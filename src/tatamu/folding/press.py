"""Pressing a fold after the hands have left: a plate flattens the crease, or a hand slides along it.

A weight is converted to a gap before the simulation, because the motion of bodies is prescribed. The crease counts as
an elastica between two plates on which its ends lie flat. With the bending rigidity B of the cloth [N m], the force P
per length of the crease [N/m], the angle phi between strip and plates and the arc length s [m], the distance D of the
layers' mid-surfaces is:

    B/2 (d phi/ds)^2 = P sin phi
    D = sqrt(B / 2P) c,   c = integral of sqrt(sin phi) from 0 to pi = 2.396
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.curves import minimum_jerk
from tatamu.base.errors import InputError
from tatamu.base.records import Record
from tatamu.folding.layout import FoldLine
from tatamu.simulation.body import Body
from tatamu.simulation.material import Material, Number

FLAT = 2.396
"""The constant c of D [-]: twice the integral of sqrt(sin) over a quarter turn."""
HALF_THICKNESS = 0.005
"""Half the thickness of a plate or a pressing hand [m]."""
RESTS = 0.3
"""Time for the cloth to fall before the pressing, and to rise after it [s]."""
MOVES = 0.4
"""Time in which a plate comes down or goes up [s]."""
HIGH, ABOVE = 0.8, 0.05
"""Heights above the hands, where a plate waits, and from which it comes down to press [m]."""
KNOTS = 16

Side = Annotated[Number, Field(ge=0.005, le=3.0)]


class Press(Record):
    """The pressing of a fold after the hands have left it."""

    tool: Literal["plate", "hand"] = "plate"
    """A plate that covers the whole crease, or a hand that slides along it."""
    size: tuple[Side, Side] | None = None
    """Size of the plate or the hand, across the fold line and along it [m]; None for 0.06 x 0.4 or 0.02 x 0.03."""
    gap: Annotated[Number, Field(gt=0.0, le=0.1)] | None = None
    """Distance between the table and the plate or the hand [m]."""
    weight: Annotated[Number, Field(gt=0.0, le=1000.0)] | None = None
    """Force on the plate or the hand [N], from which the gap is computed."""
    seconds: Annotated[Number, Field(gt=0.0, le=60.0)] = 1.0
    """Time for which a plate presses, or in which a hand slides along the crease [s]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.gap is None) == (self.weight is None):
            given = "both" if self.gap is not None else "neither"
            raise ValueError(f"must have either gap or weight, given {given}")
        return self

    @property
    def area(self) -> tuple[float, float]:
        return self.size or ((0.06, 0.4) if self.tool == "plate" else (0.02, 0.03))

    @property
    def duration(self) -> float:
        """Time from the departure of the hands until the end of the scene [s]."""
        return 2.0 * RESTS + 3.0 * MOVES + self.seconds

    def gap_over(self, material: Material, stack: float, crease: float) -> float:
        """Return the gap over a `stack` of layers that is so thick, at a `crease` that is so long [m].

        Raises:
            InputError: If the layers do not fit into the gap.
        """
        if self.weight is not None:
            force = self.weight / min(self.area[1], crease)
            return max(stack, FLAT * np.sqrt(material.bending_rigidity / (2.0 * force)) + material.thickness)
        gap = float(self.gap or 0.0)
        if not gap >= stack - 1e-9:
            raise InputError(
                f"press.gap: must be at least {1e3 * stack:.3g} mm, the thickness of all layers, given "
                f"{1e3 * gap:.3g} mm"
            )
        return gap


def press_body(press: Press, line: FoldLine, ends: tuple[float, float], gap: float, begins: float) -> Body:
    """Return the plate or the hand that presses, from the time `begins` at which the hands have left [s].

    `ends` are the coordinates of both ends of the crease along the line [m].
    """
    across, along = press.area
    low, high = ends
    start = stop = 0.5 * (low + high)
    if press.tool == "hand":
        start, stop = low + 0.5 * along, max(high - 0.5 * along, low + 0.5 * along)
    legs = (  # time of the end [s], height over the gap [m], coordinate along the line [m]
        (begins + RESTS, HIGH, start),
        (begins + RESTS + MOVES, ABOVE, start),
        (begins + RESTS + 2.0 * MOVES, 0.0, start),
        (begins + RESTS + 2.0 * MOVES + press.seconds, 0.0, stop),
        (begins + RESTS + 3.0 * MOVES + press.seconds, ABOVE, stop),
    )
    times, heights, places = [np.zeros(1)], [np.full(1, HIGH)], [np.full(1, start)]
    share = minimum_jerk(np.linspace(0.0, 1.0, KNOTS + 1)[1:])
    for until, height, place in legs:
        before = times[-1][-1], heights[-1][-1], places[-1][-1]
        times.append(np.linspace(before[0], until, KNOTS + 1)[1:])
        heights.append(before[1] + share * (height - before[1]))
        places.append(before[2] + share * (place - before[2]))
    count = 1 + KNOTS * len(legs)
    # a plate extends beyond the fold line
    plane = line.join(np.full(count, 0.5 * across - 0.01), np.concatenate(places))
    turned = 0.5 * float(np.arctan2(line.normal[1], line.normal[0]))
    return Body(
        name=f"pressing {press.tool}",
        shape="box",
        size=[0.5 * across, 0.5 * along, HALF_THICKNESS],
        times=np.concatenate(times).tolist(),
        positions=np.column_stack([plane, gap + HALF_THICKNESS + np.concatenate(heights)]),
        orientations=np.tile([np.cos(turned), 0.0, 0.0, np.sin(turned)], (count, 1)),
    )
