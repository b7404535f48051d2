"""Friction (paper, section IV-B): the coefficient at which cloth begins to slide on a board of the measured slope.

The simulated table stands at theta = asin(H_s / L_t) and its friction is halved in from both sides between a value at
which a sheet stays and one at which it slides. tan(theta), the textbook's answer, is where the search begins and what
the answer is compared with. Sliding does not depend on the sheet's shape, so a small one of the same material is used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tatamu.garments.towel import staggered_rectangle
from tatamu.material import Material
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Scene, Table

SIZE, SPACING = (0.10, 0.20), 0.02
"""Width, length and mesh spacing of the sheet [m]."""
DURATION = 0.8
"""Of a scene [s]."""
SLIDING = 5e-3
"""Mean speed over the last quarter above which the sheet slides [m/s]: it is reached 1.5e-3 below tan(theta)."""
FIRST = 0.02
"""The search begins with tan(theta) times one plus or minus this."""
RESOLUTION = 2e-3
"""The interval of the coefficient is halved until it is narrower than this."""
LARGEST = 3.0
"""Coefficients beyond this are not tried."""


@dataclass(frozen=True)
class Slope:
    """The sliding test on a board."""

    angle: float
    """theta [rad]."""

    @property
    def textbook(self) -> float:
        """tan(theta)."""
        return float(np.tan(self.angle))

    def scene(self, material: Material) -> Scene:
        """A sheet at rest on the tilted table."""
        flat, faces = staggered_rectangle(*SIZE, SPACING)
        down = np.array([np.cos(self.angle), 0.0, -np.sin(self.angle)])
        normal = np.array([np.sin(self.angle), 0.0, np.cos(self.angle)])
        start = flat[:, :1] * down + flat[:, 1:2] * [0.0, 1.0, 0.0] + 0.5 * material.thickness * normal
        still = material.model_copy(update={"air_drag": 0.0})
        return Scene(
            cloth=Cloth(vertices=start, faces=faces),
            material=still,
            table=Table(tilt=self.angle),
            duration=DURATION,
            frame_rate=30.0,
        )

    def speed(self, rollout: Rollout) -> float:
        """Mean speed down the slope over the last quarter [m/s]."""
        down = np.array([np.cos(self.angle), 0.0, -np.sin(self.angle)])
        late = len(rollout.times) * 3 // 4
        way = (rollout.positions[-1] - rollout.positions[late]).mean(axis=0) @ down
        return float(way / (rollout.times[-1] - rollout.times[late]))


@dataclass(frozen=True)
class Sliding:
    """Where a sheet begins to slide."""

    slides: float
    """Largest coefficient seen to slide."""
    sticks: float
    """Smallest seen to stick."""
    samples: tuple[tuple[float, float], ...]
    """All (coefficient, speed [m/s]) that were simulated."""
    bound: str | None = None
    """None; "at least" where it slides whatever the coefficient, "at most" where it sticks even without friction."""

    @property
    def coefficient(self) -> float:
        """Between the two."""
        return 0.5 * (self.slides + self.sticks)


def threshold(speed: Callable[[float], float], guess: float) -> Sliding:
    """Search the coefficient at which a sheet begins to slide, by halving; where there is none, the guess is kept.

    Args:
        speed: Simulates the speed at a coefficient [m/s].
        guess: Where to begin.
    """
    seen: dict[float, float] = {}

    def slides(coefficient: float) -> bool:
        seen[coefficient] = speed(coefficient)
        return seen[coefficient] > SLIDING

    low, high = _bracket(slides, guess)
    if high > LARGEST or low < 0.0:
        return Sliding(guess, guess, tuple(sorted(seen.items())), "at least" if high > LARGEST else "at most")
    while high - low > RESOLUTION:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slides(middle) else (low, middle)
    return Sliding(low, high, tuple(sorted(seen.items())))


def _bracket(slides: Callable[[float], bool], guess: float) -> tuple[float, float]:
    """A coefficient at which it slides, and a larger one at which it sticks; beyond 0 or `LARGEST` if there is none."""
    low, high = guess * (1.0 - FIRST), guess * (1.0 + FIRST)
    step = high - low
    if slides(high):
        while high + step <= LARGEST and slides(high + step):
            high, step = high + step, 2.0 * step
        return high, high + step
    while not slides(low):
        if low == 0.0:
            return -1.0, 0.0
        high, low, step = low, max(low - step, 0.0), 2.0 * step
    return low, high
