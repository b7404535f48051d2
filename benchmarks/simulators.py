"""Textbook checks and a towel fold in every simulator that is here: the figures of docs/simulators.md.

python benchmarks/simulators.py [--simulators blender mujoco native] [--fold]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np

from tatamu.errors import TatamuError
from tatamu.garments.towel import staggered_rectangle
from tatamu.material import Material
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Gripper, Scene, Table
from tatamu.simulators import SIMULATORS, simulate

MATERIAL = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4, thickness=0.001)
ELASTICA = {1.0: (0.991, 0.123), 5.0: (0.847, 0.496), 20.0: (0.445, 0.830)}
"""Reach and drop over length of the heavy elastica by Gamma = rho g L^3 / B (own solution by continuation)."""


def sheet(width: float, length: float, spacing: float = 0.02) -> tuple[np.ndarray, np.ndarray]:
    return staggered_rectangle(width, length, spacing)


def material(**changes: float) -> Material:
    return Material(**{**MATERIAL.model_dump(), **changes})


def still(vertices: np.ndarray) -> Gripper:
    return Gripper(vertices=vertices.tolist(), times=[0.0], displacements=np.zeros((1, 3)))


def fall(run: Callable[[Scene], Rollout]) -> str:
    vertices, faces = sheet(0.1, 0.2)
    rollout = run(Scene(cloth=Cloth(vertices=vertices, faces=faces), material=MATERIAL, duration=0.5))
    return f"{100 * (-rollout.positions[-1, :, 2].mean() / (9.81 * 0.125) - 1):+.2f} %"


def slide(run: Callable[[Scene], Rollout], degrees: float) -> np.ndarray:
    """Downhill way [m] over time on a table with mu = tan 20 degrees, shape (f,)."""
    vertices, faces = sheet(0.1, 0.2)
    angle = np.radians(degrees)
    down, up = np.array([np.cos(angle), 0, -np.sin(angle)]), np.array([np.sin(angle), 0, np.cos(angle)])
    start = vertices[:, :1] * down + vertices[:, 1:2] * np.array([0, 1.0, 0]) + MATERIAL.thickness / 2 * up
    made = Scene(
        cloth=Cloth(vertices=start, faces=faces),
        material=material(friction_table=float(np.tan(np.radians(20.0)))),
        table=Table(tilt=angle),
        duration=1.0,
    )
    return np.asarray(((run(made).positions - start) @ down).mean(1))


def incline(run: Callable[[Scene], Rollout]) -> str:
    creep = slide(run, 19.5)[-1]
    way = slide(run, 25.0)
    half = len(way) // 2
    acceleration = 4.0 * (way[-1] - 2.0 * way[half] + way[0])
    exact = 9.81 * (np.sin(np.radians(25)) - np.tan(np.radians(20)) * np.cos(np.radians(25)))
    return f"{1e3 * creep:.2f} mm/s; {100 * (acceleration / exact - 1):+.1f} %"


def hang(run: Callable[[Scene], Rollout]) -> str:
    errors = []
    for spacing in (0.02, 0.01):
        flat, faces = sheet(0.1, 0.3, spacing)
        vertices = np.column_stack([flat[:, 1], np.zeros(len(flat)), flat[:, 0]])
        top, low = vertices[:, 2] > 0.1499, vertices[:, 2] < -0.1499
        made = Scene(
            cloth=Cloth(vertices=vertices, faces=faces),
            material=material(air_drag=1.0),
            grippers=[still(np.flatnonzero(top))],
            duration=2.0,
        )
        stretch = -(run(made).positions[-1] - vertices)[low, 2].mean()
        errors.append(f"{100 * (stretch / (0.2 * 9.81 * 0.3**2 / 600.0) - 1):+.1f} %")
    return ", ".join(errors)


def cantilever(run: Callable[[Scene], Rollout]) -> str:
    """Error of reach and drop in % of the length, the strip held along its middle line, 2 cm mesh."""
    length, errors = 0.12, []
    vertices, faces = sheet(0.1, 0.24)
    for gamma, (reach, drop) in ELASTICA.items():
        made = Scene(
            cloth=Cloth(vertices=vertices, faces=faces),
            material=material(bending_rigidity=0.2 * 9.81 * length**3 / gamma, stretch_stiffness=1000.0, air_drag=1.0),
            grippers=[still(np.flatnonzero(np.abs(vertices[:, 0]) < 0.006))],
            duration=3.0,
        )
        tip = run(made).positions[-1][vertices[:, 0] > length - 1e-6].mean(0) / length
        errors.append(f"{100 * (tip[0] - reach):+.1f}/{100 * (-tip[2] - drop):+.1f}")
    return ", ".join(errors)


def layers(run: Callable[[Scene], Rollout]) -> str:
    """Height of the lower sheet and gap to the upper [mm]; right: 0.50 and 1.00."""
    (lower, faces), (upper, more) = sheet(0.1, 0.2), sheet(0.09, 0.18)
    vertices = np.concatenate([lower, upper + np.array([0.0, 0.0, 0.0012])])
    vertices[:, 2] += 0.0005
    cloth = Cloth(vertices=vertices, faces=np.concatenate([faces, more + len(lower)]))
    heights = 1e3 * run(Scene(cloth=cloth, material=MATERIAL, table=Table(), duration=1.0)).positions[-1, :, 2]
    below = heights[: len(lower)].mean()
    return f"{below:.2f}, {heights[len(lower) :].mean() - below:.2f}"


def fold_scene(bending_rigidity: float = 1e-4) -> Scene:
    """A towel of 0.80 x 0.34 m on a 2 cm mesh folded in half by two hands: 3 s, 60 frames per second."""
    vertices, faces = sheet(0.34, 0.80)
    vertices = vertices + np.array([0.0, 0.0, MATERIAL.thickness / 2])
    times = np.linspace(0.0, 1.0, 61)
    ease = (times * times * (3.0 - 2.0 * times))[:, None]
    points = [np.array(p) for p in ([0.0, 0, 0], [0.04, 0, 0.25], [0.6, 0, 0.3], [0.8, 0, 0.02])]
    weights = [(1 - ease) ** 3, 3 * ease * (1 - ease) ** 2, 3 * ease**2 * (1 - ease), ease**3]
    path = sum(weight * point for weight, point in zip(weights, points, strict=True))
    hands = []
    for side in (-1.0, 1.0):
        corner = np.abs(vertices[:, :2] - np.array([-0.40, side * 0.17])).max(1) < 0.025
        hands.append(
            Gripper(
                vertices=np.flatnonzero(corner).tolist(),
                opens=2.4,
                times=(0.1 + 1.9 * times).tolist(),
                displacements=path,
            )
        )
    return Scene(
        cloth=Cloth(vertices=vertices, faces=faces),
        material=material(bending_rigidity=bending_rigidity),
        table=Table(),
        grippers=hands,
        duration=3.0,
    )


def fold(run: Callable[[Scene], Rollout]) -> str:
    """Seconds, height of the loop [mm], way in the last 0.2 s [mm]."""
    rollout = run(fold_scene())
    last = rollout.positions[-1]
    way = np.linalg.norm(last - rollout.positions[-13], axis=1).max()
    return f"{rollout.info['wall_seconds']:.1f} s, {1e3 * last[:, 2].max():.0f} mm, {1e3 * way:.1f} mm"


CHECKS = {
    "free fall over 0.5 s": fall,
    "incline: creep at 19.5 degrees; acceleration at 25": incline,
    "hang: stretch, 2 cm and 1 cm mesh": hang,
    "cantilever: reach/drop at Gamma 1, 5, 20, % of L": cantilever,
    "layers: height, gap [mm]; right is 0.50, 1.00": layers,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--simulators", nargs="+", default=list(SIMULATORS), choices=list(SIMULATORS))
    parser.add_argument(
        "--fold", action="store_true", help="also fold a towel of about 870 vertices: minutes in MuJoCo"
    )
    options = parser.parse_args()
    checks = {**CHECKS, "fold: wall time, loop height, way in the last 0.2 s": fold} if options.fold else CHECKS
    print("| check | " + " | ".join(options.simulators) + " |\n|---|" + "---|" * len(options.simulators))
    for title, check in checks.items():
        cells = [_cell(check, name) for name in options.simulators]
        print(f"| {title} | " + " | ".join(cells) + " |", flush=True)


def _cell(check: Callable[[Callable[[Scene], Rollout]], str], name: str) -> str:
    try:
        return check(lambda scene: simulate(scene, name))
    except TatamuError as error:
        return str(error)


if __name__ == "__main__":
    main()
