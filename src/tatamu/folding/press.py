"""Pressing a fold after the hands have left.

A plate flattens the crease, or a hand slides along the crease. Then the plate or the hand leaves.

A weight is converted to a gap before the simulation, because the motion of bodies is prescribed. For this conversion,
the crease is modelled as an elastica (a thin elastic strip) between two parallel plates. The ends of the strip lie flat
on the plates. B is the bending rigidity of the cloth [N m], and P the force per length of the crease [N/m]. phi is the
angle between strip and plates, and s the arc length [m]. The first formula gives the angle phi. The second gives the
distance D between the mid-surfaces of the layers:

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
from tatamu.folding.ideal import FoldLine
from tatamu.simulation.body import Body
from tatamu.simulation.material import Material, Number

FLAT = 2.396
"""The constant c of the module's formula: twice the integral of sqrt(sin) over a quarter turn [-].

The formula gives the distance between two layers that are pressed together.
"""
PLATE, HAND = (0.06, 0.4), (0.02, 0.03)
"""Default sizes of a plate and of a pressing hand, each across the fold line and along it [m]."""
HALF_THICKNESS = 0.005
"""Half the thickness of a plate or of a pressing hand [m]."""
BEYOND = 0.01
"""Distance by which a plate extends beyond the fold line, to the side from which the moved cloth came [m]."""
RESTS = 0.3
"""Time from the departure of the hands until the pressing begins, in which the cloth can fall [s]. It is also the time
in which the cloth can rise after the pressing."""
MOVES = 0.4
"""Time in which a plate comes down or goes up [s]."""
HIGH, ABOVE = 0.8, 0.05
"""Two heights [m]: the plate waits at the first height, which is above the hands. It comes down to press from the
second height."""
KNOTS = 16
"""Number of knots (times with positions) that describe each motion of the plate or the hand."""

Side = Annotated[Number, Field(ge=0.005, le=3.0)]


class Press(Record):
    """The pressing of a fold after the hands have left it."""

    tool: Literal["plate", "hand"] = "plate"
    """Tool: a plate that covers the whole crease, or a hand that slides along the crease."""
    size: tuple[Side, Side] | None = None
    """Size of the plate or the hand, across the fold line and along it [m].

    If it is None, a plate has the size 0.06 x 0.4, and a hand has the size 0.02 x 0.03.
    """
    gap: Annotated[Number, Field(gt=0.0, le=0.1)] | None = None
    """Distance between the table and the plate or the hand [m]."""
    weight: Annotated[Number, Field(gt=0.0, le=1000.0)] | None = None
    """Force on the plate or the hand [N]. The gap is computed from this force."""
    seconds: Annotated[Number, Field(gt=0.0, le=60.0)] = 1.0
    """Time for which a plate presses, or in which a hand slides along the crease [s]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.gap is None) == (self.weight is None):
            given = "both" if self.gap is not None else "neither"
            raise ValueError(f"must have one of gap and weight, given {given}")
        return self

    @property
    def area(self) -> tuple[float, float]:
        """Size of the plate or the hand, across the fold line and along it [m]."""
        return self.size or (PLATE if self.tool == "plate" else HAND)

    @property
    def duration(self) -> float:
        """Time from the moment when the hands have left until the end of the scene [s]."""
        return 2.0 * RESTS + 3.0 * MOVES + self.seconds

    def gap_over(self, material: Material, stack: float, crease: float) -> float:
        """Return the distance between the table and the plate or the hand that presses [m].

        Args:
            material: Material of the cloth.
            stack: Total thickness of the layers after the fold [m].
            crease: Length of the crease [m].

        Raises:
            InputError: If the layers do not fit into the gap.
        """
        if self.weight is not None:
            force = self.weight / min(self.area[1], crease)
            return max(stack, FLAT * np.sqrt(material.bending_rigidity / (2.0 * force)) + material.thickness)
        gap = float(self.gap or 0.0)
        if not gap >= stack - 1e-9:
            raise InputError(
                f"press.gap: must be {1e3 * stack:.3g} mm or more, which the layers take, given {1e3 * gap:.3g} mm"
            )
        return gap


def press_body(press: Press, line: FoldLine, ends: tuple[float, float], gap: float, begins: float) -> Body:
    """Return the plate or the hand that presses, as a rigid body with a prescribed motion.

    Args:
        press: Options of the press.
        line: The fold line.
        ends: Coordinates of both ends of the crease along the line [m].
        gap: Distance between the table and the plate or the hand [m].
        begins: Time at which the hands have left [s].
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
    plane = line.join(np.full(count, 0.5 * across - BEYOND), np.concatenate(places))
    turned = 0.5 * float(np.arctan2(line.normal[1], line.normal[0]))
    return Body(
        name=f"pressing {press.tool}",
        shape="box",
        size=[0.5 * across, 0.5 * along, HALF_THICKNESS],
        times=np.concatenate(times).tolist(),
        positions=np.column_stack([plane, gap + HALF_THICKNESS + np.concatenate(heights)]),
        orientations=np.tile([np.cos(turned), 0.0, 0.0, np.sin(turned)], (count, 1)),
    )
