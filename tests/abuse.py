"""Random scenes that no sensible person makes, and what becomes of them: a rollout or a clear error, nothing else.

A scene follows from its seed alone. Each is kept short by an estimate of the explicit steps that it needs, so that ten
thousand take minutes.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from tatamu.base.errors import InputError, SimulationError
from tatamu.base.files import validated
from tatamu.simulation.mesh.topology import Topology, edge_lengths
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate
from tests.physics.meshes import LAYOUTS, Mesh, right
from tests.physics.scenes import joined, raised, sewn

DECADES = {
    "areal_density": (1e-3, 10.0),
    "stretch_stiffness": (1.0, 1e4),
    "bending_rigidity": (1e-7, 1e-3),
    "thickness": (1e-5, 0.05),
    "friction_table": (1e-3, 10.0),
    "friction_cloth": (1e-3, 10.0),
    "air_drag": (1e-3, 10.0),
}
"""Least and largest of each material parameter; drawn evenly in its logarithm."""
MAX_MESH = 5000
"""Triangles."""
UP = np.array([0.0, 0.0, 1.0])
STEEPEST = np.radians(80.0)
WORK = 1.5e6
"""Vertices, and a hundred more, times explicit steps of one scene at most: a scene takes about a tenth of a second."""
FRAME_RATES = (1.0, 23.976, 30.0, 60.0, 144.0, 1000.0)
MAX_FRAMES = 60
KINDS = ("still", "carry", "jerk", "drop", "cross", "pull apart", "late")
"""What hands do."""


def scene(seed: int) -> Scene:
    """The scene of a seed.

    Raises:
        InputError: What was drawn is no scene, for instance as two hands hold one vertex.
    """
    random = np.random.default_rng(seed)
    material = {name: _log(random, *bounds) for name, bounds in DECADES.items()}
    material["poisson_ratio"] = float(random.uniform(-0.9, 0.9))
    for name in ("bending_rigidity", "air_drag", "friction_table", "friction_cloth"):
        material[name] *= float(random.random() > 0.1)
    if seed % 2:
        material["compression"] = _log(np.random.default_rng([seed, 1]), 1e-3, 1.0)
    size = _log(random, 0.05, 2.0)
    rest, faces, seams = _cloth(random, size, material["thickness"])
    start = _placed(random, rest, size, material["thickness"])
    gravity = float(random.choice([0.0, 1.62, 9.81, 100.0], p=[0.05, 0.1, 0.8, 0.05]))
    duration, rate = _time(random, _longest(rest, faces, material))
    raw = {
        "cloth": {"vertices": start, "rest_vertices": rest, "faces": faces, "seams": seams},
        "material": material,
        "table": _table(random),
        "grippers": _hands(random, start, size, duration),
        "bodies": _bodies(np.random.default_rng([seed, 2]), start, size, duration) if seed % 3 == 0 else [],
        "gravity": gravity,
        "duration": duration,
        "frame_rate": rate,
    }
    return validated(Scene, raw, _name(seed))


def outcome(seed: int, simulator: str = "native") -> str:
    """What became of the scene of a seed, in words that are the same for all outcomes of one kind.

    Raises:
        Exception: Whatever the simulator raised that is no error of ours.
    """
    try:
        return judged(simulate(scene(seed), simulator))
    except InputError as error:
        return f"refused: {_kind(str(error).removeprefix(_name(seed) + ': '))}"
    except SimulationError as error:
        return f"stopped: {_kind(str(error))}"


def _name(seed: int) -> str:
    return f"abuse {seed}"


def judged(rollout: Rollout) -> str:
    """`rollout` if a rollout is finite, else what it is; either may come with warnings."""
    return "rollout" if np.isfinite(rollout.positions).all() else "WRONG: a rollout that is not finite"


def acceptable(kind: str) -> bool:
    """Whether users may meet this outcome."""
    return kind.startswith(("rollout", "refused: ", "stopped: "))


def _kind(message: str) -> str:
    """A message without its numbers."""
    return re.sub(r"\d[\d.e+-]*", "..", message)


def _log(random: np.random.Generator, low: float, high: float) -> float:
    """A number from `low` to `high`, evenly in its logarithm."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def _cloth(random: np.random.Generator, size: float, thickness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unstrained points, triangles and seams: one sheet, two loose sheets, or two layers sewn along two sides."""
    layers = int(random.choice([1, 1, 2, 3]))
    plan, faces = _mesh(random, size, _log(random, 2, MAX_MESH / min(layers, 2)))
    flat = raised(plan)
    if layers == 1:
        seams = Topology(faces).hinges[:, :2]
        return flat, faces, seams[random.random(len(seams)) < random.choice([0.0, 0.1, 1.0])]
    gap = thickness * random.choice([0.1, 1.0, 1.5])
    if layers == 2:
        points, both, _ = joined([(flat, faces), (raised(plan, gap), faces)])
        return points, both, np.empty((0, 2), dtype=np.int64)
    return sewn((plan, faces), gap)


def _mesh(random: np.random.Generator, size: float, triangles: float) -> Mesh:
    """A rectangle of at most about `triangles` triangles in one of the layouts."""
    width = size * random.uniform(0.2, 1.0)
    spacing = float(np.sqrt(2.0 * size * width / triangles))
    layout = LAYOUTS[str(random.choice(list(LAYOUTS)))] if triangles > 40 else right
    return layout(size, width, spacing)


def _placed(random: np.random.Generator, rest: np.ndarray, size: float, thickness: float) -> np.ndarray:
    """Where the cloth starts: flat, at any height, upright, crumpled, stretched, or through the table."""
    pose = random.choice(["flat", "high", "upright", "crumpled", "stretched", "through"])
    start = rest + 0.5 * thickness * UP
    if pose == "high":
        start = start + random.uniform(0.0, 1.0) * UP
    elif pose == "upright":
        start = start[:, [0, 2, 1]]
    elif pose == "crumpled":
        start = start + size * 10 ** random.uniform(-4.0, -1.5) * random.normal(size=rest.shape)
    elif pose == "stretched":
        start = start * random.uniform(0.6, 1.6, 3)
    elif pose == "through":
        start = start[:, [0, 2, 1]] - 0.3 * size * UP
    return np.asarray(start)


def _longest(rest: np.ndarray, faces: np.ndarray, material: dict[str, float]) -> float:
    """Duration that WORK allows [s], by the waves of membrane and bending across the smallest triangle."""
    height = 0.5 * float(edge_lengths(rest, Topology(faces).edges).min())
    rho = material["areal_density"]
    stretch = 2.0 * np.sqrt(material["stretch_stiffness"] / (rho * (1.0 - material["poisson_ratio"] ** 2))) / height
    bend = 4.0 * np.sqrt(material["bending_rigidity"] / rho) / height**2
    return float(WORK / ((len(rest) + 100) * max(stretch, bend, 5e3)))


def _time(random: np.random.Generator, longest: float) -> tuple[float, float]:
    """Duration [s] and frames per second, at times so that no frame fits."""
    duration = min(_log(random, 1e-3, 2.0), longest)
    rate = float(random.choice(FRAME_RATES)) if random.random() < 0.5 else random.uniform(0.5, MAX_FRAMES) / duration
    return duration, float(min(rate, MAX_FRAMES / duration, 1e4))


def _table(random: np.random.Generator) -> dict[str, float] | None:
    if random.random() < 0.15:
        return None
    tilt = random.choice([0.0, random.uniform(-STEEPEST, STEEPEST), STEEPEST])
    return {"height": 0.0, "tilt": float(tilt)}


def _hands(random: np.random.Generator, start: np.ndarray, size: float, duration: float) -> list[dict[str, Any]]:
    """Up to four hands; `cross` and `pull apart` are for two, one at each end."""
    kind = str(random.choice(KINDS))
    count = 2 if kind in ("cross", "pull apart") else int(random.integers(0, 5))
    order = np.argsort(start[:, 0], kind="stable")
    middles = [order[0], order[-1]] if count == 2 else random.integers(0, len(start), count)
    reach = size * random.choice([0.0, 0.05, 0.2])
    hands = []
    for number, middle in enumerate(middles):
        held = np.flatnonzero(np.linalg.norm(start - start[middle], axis=1) <= reach)
        across = start[middles[-1 - number]] - start[middle]
        hands.append({"vertices": held.tolist(), **_motion(random, kind, across, size, duration)})
    return hands


def _motion(random: np.random.Generator, kind: str, across: np.ndarray, size: float, duration: float) -> dict[str, Any]:
    """When a hand closes and opens, and its displacements; `across` leads to the hand opposite [m]."""
    times = [0.0, 0.5 * duration, 0.9 * duration]
    closes, opens = 0.0, None
    far = size * 10 ** random.uniform(-3.0, 0.5)
    displacements = far * np.cumsum(np.vstack([np.zeros(3), random.normal(size=(2, 3))]), axis=0)
    if kind == "still":
        displacements = np.zeros((3, 3))
    elif kind == "jerk":
        times, displacements = [0.0, 1e-3, 2e-3], far * random.choice([-1.0, 1.0], (3, 3))
    elif kind == "cross":
        displacements = np.outer([0.0, 1.0, 1.0], across) + 0.01 * size * UP
    elif kind == "pull apart":
        displacements = np.outer([0.0, 0.1, random.uniform(0.1, 2.0)], -across)
    elif kind == "drop":
        opens = duration * random.uniform(0.01, 1.0)
    elif kind == "late":
        closes = duration * random.uniform(0.0, 1.5)
        opens = closes + duration * random.uniform(1e-6, 0.5)
    return {"times": times, "displacements": displacements, "closes": closes, "opens": opens}


def _bodies(random: np.random.Generator, start: np.ndarray, size: float, duration: float) -> list[dict[str, Any]]:
    """Up to four bodies of any shape that fly, turn and jump about the cloth, some of them from within it."""
    bodies = []
    for _ in range(int(random.integers(1, 5))):
        shape = str(random.choice(["box", "sphere", "capsule"]))
        sizes = [_log(random, 1e-4, size) for _ in range({"box": 3, "sphere": 1, "capsule": 2}[shape])]
        knots = int(random.integers(1, 5))
        times = np.cumsum(random.uniform(1e-4, duration, knots)) - random.uniform(0.0, duration)
        centre = start[random.integers(len(start))] + size * random.normal(size=3) * random.choice([0.01, 0.3, 1.0])
        way = size * 10 ** random.uniform(-3.0, 0.5) * random.normal(size=(knots, 3))
        turns = random.normal(size=(knots, 4))
        bodies.append(
            {
                "shape": shape,
                "size": sizes,
                "friction": float(random.choice([0.0, 0.5, 10.0])),
                "times": times.tolist(),
                "positions": (centre + np.cumsum(way, axis=0)).tolist(),
                "orientations": (turns / np.linalg.norm(turns, axis=1, keepdims=True)).tolist(),
            }
        )
    return bodies
