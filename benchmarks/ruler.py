"""Simulated cloth, measured as a person would measure cloth."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

import numpy as np

from tatamu.base.files import validated
from tatamu.calibration import Measurements
from tatamu.calibration.elongation import Elongation, Grasp
from tatamu.calibration.friction import SLIDING, Slope
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.loop import HEIGHT, LIFT, Loop
from tatamu.calibration.push import Push
from tatamu.calibration.sag import Sag
from tatamu.garments import make_garment
from tatamu.simulation.material import Material

BOARD = 0.8
"""Length of the board [m]."""
PUSHED = 0.05
"""Distance by which a ruler pushes the cloth [m]."""
MARK = 1e-3
"""Marks of the ruler [m] and of the scale [kg]."""
HUMAN = {"length": 1e-3, "mass": 1e-3, "H_s": 5e-3}
"""Errors of readings that calibration expects by default."""
FINE_HANG, FINE_SAG, FINE_LOOP = 0.014, 18, 7
"""Hidden cloth is simulated on finer meshes than calibration's: edge length [m], rows, edges over the loop's height."""


def measured(
    material: Material,
    simulator: str,
    size: tuple[float, float],
    free_length: float,
    spacing: float | None = None,
    more: Collection[str] = (),
) -> dict[str, float]:
    """True lengths, angle and mass of a simulated cloth; of `more`, "loop" and "push", what is asked for."""
    lab = Laboratory(simulator)
    hung = Elongation(make_garment("towel", size, material, spacing or FINE_HANG), [Grasp(edge="bottom")])
    strip = Sag(free_length, spacing or free_length / FINE_SAG)
    still = settling(material)
    angle = slipping_angle(lambda at: Slope(at).speed(lab.run(Slope(at).scene(material), "friction")), material)
    longer = lab.reading(hung, still)
    return {
        "mass": material.areal_density * size[0] * size[1],
        "L1": size[1] + longer,
        "L2": size[1],
        "H_s": BOARD * float(np.sin(angle)),
        "sag": lab.reading(strip, still),
        **({"loop": loop_height(simulator, still, spacing)} if "loop" in more else {}),
        **({"moved": lab.reading(Push(size[1], PUSHED, spacing), material)} if "push" in more else {}),
        "free_length": free_length,
        "angle": angle,
    }


def settling(material: Material) -> Material:
    """The same cloth in thick air, where Blender's own numbers would have it swing for long; at rest it is the same."""
    raw = material.blender
    return material if raw is None else material.model_copy(update={"blender": {**raw, "air_damping": 10.0}})


def loop_height(simulator: str, material: Material, spacing: float | None) -> float:
    """Height of a fold's loop [m], of strips cut to it as it turns out."""
    height = HEIGHT * material.bending_length + LIFT * material.thickness
    before = 0.0
    while not 0.8 * height < before < 1.25 * height:
        before = height
        edge = spacing or max(before / FINE_LOOP, 1.6 * material.thickness)
        test = Loop(before, material.thickness, edge)
        height = Laboratory(simulator).reading(test, material)  # a new one: it knows one test of a name
    return height


def slipping_angle(speed: Callable[[float], float], material: Material) -> float:
    """Slope at which the cloth starts to slide as the board is lifted [rad], to 0.02 degrees."""
    low, high = 0.0, np.radians(60.0)
    while high - low > np.radians(0.02):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if speed(middle) > SLIDING else (middle, high)
    return 0.5 * (low + high)


def readings(
    true: dict[str, float],
    size: tuple[float, float],
    errors: dict[str, float] = HUMAN,
    random: np.random.Generator | None = None,
    more: Collection[str] = (),
    **garment: Any,
) -> Measurements:
    """What a person reads: with the stated errors if there is a generator, and rounded to the marks.

    Of `more`, "loop" and "push", what is asked for is read too. `garment` is what else the table of that name says.
    """

    def read(value: float, kind: str) -> float:
        noisy = value + (random.normal(0.0, errors[kind]) if random else 0.0)
        return max(MARK, round(noisy / MARK) * MARK)

    lengths = {name: read(true[name], "length") for name in ("L1", "L2", "sag", "free_length")}
    lengths["L1"] = max(lengths["L1"], lengths["L2"])
    lengths["sag"] = min(lengths["sag"], lengths["free_length"] - MARK)
    told = [read(side, "length") if random else side for side in size]
    return validated(
        Measurements,
        {
            "garment": {"name": "towel", "size": told, "mass": read(true["mass"], "mass"), **garment},
            "elongation": {"grasps": [{"edge": "bottom"}], "L1": lengths["L1"], "L2": lengths["L2"]},
            "friction": {"L_t": read(BOARD, "length"), "H_s": read(true["H_s"], "H_s")},
            "sag": {"edge": "bottom", "free_length": lengths["free_length"], "sag": lengths["sag"]},
            "errors": errors,
            **({"loop": {"height": read(true["loop"], "length")}} if "loop" in more else {}),
            **({"push": _pushed(size[1], true["moved"])} if "push" in more else {}),
        },
        "readings",
    )


def _pushed(length: float, moved: float) -> dict[str, float]:
    return {"length": length, "pushed": PUSHED, "moved": min(round(max(moved, 0.0) / MARK) * MARK, PUSHED)}
