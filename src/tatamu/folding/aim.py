"""Where hands aim, so that errors that are known neither bring a finger onto the table nor beside the cloth."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from tatamu.base.records import Record
from tatamu.simulation.material import Number

Length = Annotated[Number, Field(ge=0.0, le=0.05)]


class Aim(Record):
    """Room that hands leave. A hand that grasps deeper also releases deeper, so that the cloth ends where it should."""

    height: Length = 0.0
    """How much higher the hands aim [m]."""
    into: Length = 0.0
    """How much deeper the hands grasp, from the edge into the cloth [m]."""
    from_end: Length = 0.0
    """Minimum distance of a grasp from the ends of its edge [m]."""
