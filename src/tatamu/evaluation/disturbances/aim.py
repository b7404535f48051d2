"""The aim that follows from disturbances: room, so that few hands meet the table or miss the cloth.

One hand meets the table with a probability of 0.0025, and misses the cloth with the same. With the quantile z of the
normal distribution at 1 - 0.0025,

    height   >= z s_up    - compliance                    no hand is lower than its fingers yield
    into     >= z s_into  - (1 - sqrt(MIN_HELD)) PAD      the pads cover enough cloth in depth,
    from_end >= z s_along - (1 - sqrt(MIN_HELD)) w / 2    and in width

s_up, s_into and s_along are standard deviations of one hand against the cloth. A hand misses the cloth if its pads
cover less than MIN_HELD of what they cover at its vertex; depth and width may each lose the square root of that.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from tatamu.evaluation.disturbances.description import Disturbances
from tatamu.evaluation.disturbances.disturbed import MIN_HELD
from tatamu.evaluation.disturbances.scenario import deviations
from tatamu.folding.aim import Aim
from tatamu.folding.fingers import PAD, Fingers


def aim_for(disturbances: Disturbances, fingers: Fingers) -> Aim:
    """Return the aim for disturbances, no deeper than the fingers reach.

    Means of the disturbances do not count, because a correction undoes them.
    """
    known = deviations(disturbances)

    def spread(*terms: tuple[float, str]) -> float:
        return float(np.sqrt(sum((factor * known.get(name, 0.0)) ** 2 for factor, name in terms)))

    def hands(name: str) -> float:
        return max(known.get(f"{name}.left", 0.0), known.get(f"{name}.right", 0.0))

    z = float(ndtri(1.0 - 0.0025))
    lost = 1.0 - np.sqrt(MIN_HELD)
    up = spread((1.0, "hands.offset.up"), (0.5, "hands.difference.up"), (1.0, "table.height"))
    into = np.hypot(hands("grasp.into"), spread((1.0, "cloth.place.along")))
    along = np.hypot(hands("grasp.along"), spread((1.0, "cloth.place.across")))
    depth = min(z * into - lost * PAD, fingers.length - PAD)
    return Aim(
        height=_room(z * up - fingers.compliance),
        into=_room(depth),
        from_end=_room(z * along - lost * 0.5 * fingers.width),
    )


def _room(value: float) -> float:
    """Return a length of an aim in tenths of a millimetre, at most 5 cm. Larger errors need a better camera."""
    return round(min(max(0.0, float(value)), 0.05), 4)
