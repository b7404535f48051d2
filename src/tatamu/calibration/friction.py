"""Test *friction* (paper, section IV-B): cloth starts to slide on a board of the measured slope.

The simulated table has the slope theta = asin(H_s / L_t). The coefficient of friction is found by bisection between a
value at which a small simulated sheet stays and one at which it slides, from the textbook's coefficient tan(theta).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from tatamu.calibration.estimate import Estimate, Fit
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.readings import Lengths, Reading, TestEntry
from tatamu.calibration.test import CLOTH, LaterTest, Readings, Specimen
from tatamu.show.drawing import Drawing
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Scene, Table

SIZE, SPACING = (0.10, 0.20), 0.02
"""Width, length and mesh spacing of the simulated sheet [m]."""
SLIDING = 5e-3
"""Maximum mean speed over the last quarter of the time of a sheet that counts as at rest [m/s]. A sheet reaches this
speed if its coefficient of friction is 1.5e-3 below tan(theta)."""
FIRST = 0.02
"""Relative difference between tan(theta) and the first two coefficients of the search."""
RESOLUTION = 2e-3
"""Largest width of the last interval of a bisection of the coefficient of friction [-]."""
MAX_FRICTION = 3.0
"""Largest coefficient of friction that is tried in the search."""


class FrictionReadings(TestEntry):
    """Length of the board, and height of its lifted end when the cloth slides (paper, section IV-B)."""

    taken: ClassVar = {"L_t": ("L_t", "length"), "H_s": ("H_s", "H_s")}

    L_t: Lengths
    """Length of the board from the lower end to the lifted end [m]."""
    H_s: Lengths
    """Height of the lifted end when the cloth starts to slide [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        board = float(np.mean(self.L_t))
        for height in self.H_s:
            if height >= board:
                raise ValueError(f"H_s ({height:g} m) must be less than L_t ({board:g} m), the length of the board")
        if max(self.H_s) > 0.95 * board:
            raise ValueError(
                f"H_s ({max(self.H_s):g} m) must give a slope below 70 degrees on a board of {board:g} m; "
                "check that the cloth is not caught on the board"
            )
        return self


@dataclass(frozen=True)
class Slope(LaterTest):
    """The test of cloth that slides on a board."""

    angle: float
    """Slope theta of the board [rad]."""

    name = "friction"
    parameter = "friction_table"
    entry = FrictionReadings
    samples = "speed"

    @classmethod
    def of(cls, entry: FrictionReadings, specimen: Specimen) -> Self:
        return cls(float(np.arcsin(np.mean(entry.H_s) / np.mean(entry.L_t))))

    @property
    def textbook(self) -> float:
        """The coefficient of friction by the textbook."""
        return float(np.tan(self.angle))

    def scene(self, material: Material) -> Scene:
        flat, faces = staggered_rectangle(*SIZE, SPACING)
        down = np.array([np.cos(self.angle), 0.0, -np.sin(self.angle)])
        normal = np.array([np.sin(self.angle), 0.0, np.cos(self.angle)])
        start = flat[:, :1] * down + flat[:, 1:2] * [0.0, 1.0, 0.0] + 0.5 * material.thickness * normal
        still = material.model_copy(update={"air_drag": 0.0})
        return Scene(
            cloth=Cloth(vertices=start, faces=faces),
            material=still,
            table=Table(tilt=self.angle),
            duration=0.8,
            frame_rate=30.0,
        )

    def speed(self, rollout: Rollout) -> float:
        """Return the mean speed down the slope over the last quarter of the simulated motion [m/s]."""
        down = np.array([np.cos(self.angle), 0.0, -np.sin(self.angle)])
        late = len(rollout.times) * 3 // 4
        distance = (rollout.positions[-1] - rollout.positions[late]).mean(axis=0) @ down
        return float(distance / (rollout.times[-1] - rollout.times[late]))

    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:

        def speed(coefficient: float) -> float:
            scene = self.scene(material.model_copy(update={"friction_table": coefficient}))
            return self.speed(laboratory.run(scene, self.name))

        found = threshold(speed, self.textbook)
        board, height = readings["L_t"], readings["H_s"]
        both = np.hypot(height.uncertainty, np.sin(self.angle) * board.uncertainty)
        slope = Reading(self.angle, float(both / (board.value * np.cos(self.angle))), unit="rad")
        resolution = float((found.sticks - found.slides) / found.coefficient / np.sqrt(12.0))
        fit = self.fit(slope, self.angle, found.bound, found.samples, resolution=resolution)
        return material.model_copy(update={"friction_table": found.coefficient}), fit

    def derivatives(self, readings: Readings, fit: Fit) -> tuple[dict[str, float], dict[str, float]]:
        # The coefficient is mu = tan(theta), where theta is the slope of the board. The slope follows from sin(theta) =
        # H_s / L_t, with the height H_s of the lifted end and the length L_t of the board.
        per_radian = 2.0 / np.sin(2.0 * self.angle)  # d ln tan(theta) / d theta
        per_height = per_radian / (readings["L_t"].value * np.cos(self.angle))
        return {}, {"H_s": per_height, "L_t": -per_height * np.sin(self.angle)}

    def record(self) -> dict[str, float]:
        return {"tan_theta": self.textbook}

    def sentence(self, fit: Fit) -> str:
        return (
            f"θ = asin(H_s / L_t) = {np.degrees(fit.measured):.1f} ± {np.degrees(fit.uncertainty):.1f} degrees; "
            f"tan θ = {self.textbook:.3f}."
        )

    def remark(self, estimate: Estimate, fit: Fit) -> list[str]:
        off = estimate.material.friction_table / self.textbook - 1.0
        values = {"simulator": estimate.simulator, "off": 100 * off, "textbook": self.textbook}
        return [] if abs(off) < 0.02 else [self.texts["remark"].format(**values)]

    def drawing(self, shape: np.ndarray) -> str:
        board = 0.6
        top = board * np.array([np.cos(self.angle), np.sin(self.angle)])
        right, high = top
        normal = np.array([-np.sin(self.angle), np.cos(self.angle)])
        drawing = Drawing.around(np.array([(0.0, 0.0), (right + 0.08, high + 0.05), (right + 0.1, 0.0)]), 320.0, 240.0)
        drawing.line([(-0.02, 0.0), (right + 0.1, 0.0)], "muted", 1.5)
        drawing.line([(0.0, 0.0), top], "muted", 5.0)
        half = 0.5 * 1.2 * SIZE[1] * top / board
        drawing.line([0.55 * top - half + 0.012 * normal, 0.55 * top + half + 0.012 * normal], CLOTH, 5.0)
        drawing.dimension((right + 0.03, 0.0), (right + 0.03, high), "H_s")
        drawing.dimension(0.05 * normal, top + 0.05 * normal, "L_t")
        turn = np.linspace(0.0, self.angle, 24)
        drawing.line(0.12 * np.column_stack([np.cos(turn), np.sin(turn)]), "ink", 1.0)
        drawing.label((0.16 * np.cos(self.angle / 2), 0.16 * np.sin(self.angle / 2) - 0.008), "θ")
        return drawing.svg()


@dataclass(frozen=True)
class Sliding:
    """The result of the search for the coefficient of friction at which a sheet starts to slide."""

    slides: float
    """Largest coefficient at which the sheet slid."""
    sticks: float
    """Smallest coefficient at which the sheet did not slide."""
    samples: tuple[tuple[float, float], ...]
    """All simulated pairs of a coefficient and the resulting speed [m/s]."""
    bound: str | None = None
    """ "at least" if the sheet slides at every coefficient, "at most" if it stays without friction; otherwise None."""

    @property
    def coefficient(self) -> float:
        """The coefficient of friction: the mean of `slides` and `sticks`."""
        return 0.5 * (self.slides + self.sticks)


def threshold(speed: Callable[[float], float], guess: float) -> Sliding:
    """Find the coefficient at which a sheet starts to slide, by bisection; without any, the guess is kept.

    `speed` simulates the speed at a coefficient [m/s].
    """
    seen: dict[float, float] = {}

    def slides(coefficient: float) -> bool:
        seen[coefficient] = speed(coefficient)
        return seen[coefficient] > SLIDING

    low, high = _bracket(slides, guess)
    if high > MAX_FRICTION or low < 0.0:
        return Sliding(guess, guess, tuple(sorted(seen.items())), "at least" if high > MAX_FRICTION else "at most")
    while high - low > RESOLUTION:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slides(middle) else (low, middle)
    return Sliding(low, high, tuple(sorted(seen.items())))


def _bracket(slides: Callable[[float], bool], guess: float) -> tuple[float, float]:
    """Return a coefficient at which the sheet slides, and a larger one at which it stays.

    A value outside the range of coefficients stands for one that does not exist.
    """
    low = guess * (1.0 - FIRST)
    high = guess * (1.0 + FIRST)
    step = high - low
    if slides(high):
        while high + step <= MAX_FRICTION and slides(high + step):
            high = high + step
            step = 2.0 * step
        return high, high + step
    while not slides(low):
        if low == 0.0:
            return -1.0, 0.0
        high = low
        low = max(low - step, 0.0)
        step = 2.0 * step
    return low, high
