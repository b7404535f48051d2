"""Figures of docs/notes/second-opinion.md: friction of layers, and how far simulators agree on towels.

    python benchmarks/crosscheck.py --out DIR [--simulators native,blender,mujoco] [--only towel] [--write-docs]

Parts: `friction` of moving layers; stacks at rest by Blender's `rounds` of contact; the `small` towel; the default
`towel`, which takes half an hour of processor time in Blender and hours in MuJoCo. A fold that is there already is not
run again.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from tests.physics.checks.friction import layers

from benchmarks.tables import markdown, publish
from tatamu.after.second_opinion.agreement import Agreement, compare, manipulations
from tatamu.after.second_opinion.check import modify_scene
from tatamu.after.second_opinion.matrix import HEAD, pair_cells, save
from tatamu.api import learn
from tatamu.folding.score import score
from tatamu.folding.task import make_task
from tatamu.simulation.blender import mapping
from tatamu.simulation.material import GRAVITY
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.mesh.subdivision import on_coarse_mesh
from tatamu.simulation.mesh.topology import areas, lumped
from tatamu.simulation.presets import load_preset
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tatamu.simulation.simulators import simulate
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

PARTS = ("friction", "rounds", "small", "towel")
SMALL_SIZE, SMALL_SPACING = (0.20, 0.40), 0.015
"""Size of the small towel, and spacing of its mesh [m], which is fine enough for MuJoCo's bending."""
Row = dict[str, str]
ROUNDS = (2, 4, 8, 12, 48)
"""Blender's rounds of contact in each substep; Blender's default is 2, tatamu's is 12."""
FRICTION, TILT, DURATION = 0.5, 21.5, 0.6
"""Between layers; of the table [degrees], under which nothing should move up to 26.6; how long [s]."""
ON = ("2 layers: on the table [mm]", "on 1st", "4 layers: on the table [mm]", "on the 1st", "on the 2nd", "on the 3rd")
START = 0.05
"""Time at which the upper sheet starts to move [s]."""


def drawn(mu: float, speed: float) -> tuple[Scene, int, float]:
    """A sheet drawn over another on a table without friction: scene, vertices of the lower one, m_upper / m_lower."""
    (lower, faces), (upper, more) = staggered_rectangle(0.12, 0.5, 0.013), staggered_rectangle(0.09, 0.2, 0.013)
    terry = load_preset("terry").material
    thickness = terry.thickness
    vertices = np.concatenate([lower, upper - np.array([0.1, 0.0, -thickness])]) + np.array([0.0, 0.0, thickness / 2])
    faces = np.concatenate([faces, more + len(lower)])
    front = len(lower) + np.flatnonzero(upper[:, 0] > upper[:, 0].max() - 1e-6)
    hand = Gripper(
        vertices=front.tolist(), times=[START, START + 1.0], displacements=np.array([[0.0, 0, 0], [speed, 0, 0]])
    )
    scene = Scene(
        cloth=Cloth(vertices=vertices, faces=faces),
        material=terry.model_copy(update={"friction_table": 0.0, "friction_cloth": mu, "air_drag": 0.0}),
        table=Table(),
        grippers=[hand],
        duration=START + min(0.25, 0.12 / speed),
        frame_rate=120.0,
    )
    weights = lumped(areas(vertices, faces), faces, len(vertices))
    free = np.setdiff1d(np.arange(len(lower), len(vertices)), front)
    return scene, len(lower), float(weights[free].sum() / weights[: len(lower)].sum())


def carried(simulator: str, mu: float, speed: float) -> float:
    """Acceleration of the lower sheet over mu g m_upper / m_lower, while the upper one slides on it."""
    scene, count, ratio = drawn(mu, speed)
    rollout = simulate(scene, simulator)
    cloth = scene.cloth
    weights = lumped(areas(cloth.vertices, cloth.faces), cloth.faces, len(cloth.vertices))[:count]
    velocity = np.gradient(np.average(rollout.positions[:, :count, 0], axis=1, weights=weights), rollout.times)
    exact = mu * GRAVITY * ratio
    sliding = (rollout.times > START + 0.01) & (rollout.times <= START + 0.8 * speed / exact)
    return float(np.polyfit(rollout.times[sliding], velocity[sliding], 1)[0] / exact)


def friction(simulators: list[str]) -> list[Row]:
    """Return the friction of moving layers over Coulomb's."""
    cases = [(mu, speed) for mu in (0.2, 0.5) for speed in (0.3, 1.0)]
    return [
        {
            "lower sheet's acceleration over Coulomb's": f"mu = {mu:g}, {speed:g} m/s",
            **{name: f"{carried(name, mu, speed):.2f}" for name in simulators},
        }
        for mu, speed in cases
    ]


def rounds(simulators: list[str]) -> list[Row]:
    """Stacks on a table tilted by less than would move them: how far each layer slips on what it lies on."""
    rows = []
    for name in simulators:
        for many in ROUNDS if name == "blender" else (None,):
            with patch.object(mapping, "COLLISION_LOOPS", many):
                cells = [f"{1e3 * way:.2f}" for count in (2, 4) for way in slips(name, count)]
            rows.append({"": name if many is None else f"{name}, {many} rounds", **dict(zip(ON, cells, strict=True))})
    return rows


def slips(simulator: str, count: int) -> list[float]:
    """Way down of each layer relative to the one below, or to the table [m]."""
    scene, members = layers(count, FRICTION, np.radians(TILT), DURATION)
    rollout = simulate(scene, simulator)
    down = [np.cos(np.radians(TILT)), 0.0, -np.sin(np.radians(TILT))]
    ways = [float((rollout.positions[-1] - rollout.positions[0])[layer].mean(axis=0) @ down) for layer in members]
    return [upper - lower for lower, upper in pairwise([0.0, *ways])]


def pairs(agreement: Agreement) -> list[Row]:
    """Return a row for each pair of simulators."""
    return [dict(zip(HEAD, pair_cells(pair), strict=True)) for pair in agreement.pairs]


def distances(agreement: Agreement) -> list[Row]:
    """Return the mean vertex distance of each manipulation in each simulator."""
    return [{"manipulation": name, **_distances(agreement, name)} for name in agreement.manipulations]


def _distances(agreement: Agreement, name: str) -> Row:
    scores = {simulator: agreement.entries[name, simulator].score for simulator in agreement.simulators}
    return {who: f"{1e3 * score.mean_vertex_distance:.1f}" if score else "failed" for who, score in scores.items()}


def on_half_the_mesh(learned: Result, count: int) -> dict[object, Row]:
    """Mean vertex distance of each manipulation in `native` on half the mesh spacing."""
    found: dict[object, Row] = {}
    for name, (scene, way) in manipulations(learned, count, seed=0).items():
        print(name, "in native on half the spacing", flush=True)
        rollout = on_coarse_mesh(simulate(modify_scene(scene, None, halved=True), "native"), learned.faces)
        reached = score(learned.task.fold, way, rollout.positions[-1])
        found[name] = {"native, half the spacing": f"{1e3 * reached.mean_vertex_distance:.1f}"}
    return found


def agreed(simulators: list[str], folder: Path, options: argparse.Namespace, **size: Any) -> Agreement:
    """Learn a towel in `native` by 15 trials and compare the simulators on it."""
    settings = LearnOptions(trials=15, seed=0, disturbances="none", coarse=False)
    learned = learn(make_task("towel", **size), settings, out=folder / "towel")
    assert isinstance(learned, Result)
    told = lambda manipulation, simulator: print(manipulation, "in", simulator, flush=True)  # noqa: E731
    agreement = compare(learned, simulators, folder / "agreement", count=options.random, progress=told)
    save(agreement, folder / "agreement")
    return agreement


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--simulators", default="native,blender,mujoco")
    parser.add_argument("--random", type=int, default=10)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--write-docs", action="store_true", help="write the tables into docs/notes/second-opinion.md")
    options = parser.parse_args()
    names = options.simulators.split(",")
    for part in options.only:
        for mark, rows in made(part, names, options):
            print(markdown(rows), flush=True)
            if options.write_docs:
                publish(f"agreement: {mark}", markdown(rows))


def made(part: str, names: list[str], options: argparse.Namespace) -> Iterator[tuple[str, list[Row]]]:
    """The tables of a part, and where they go."""
    if part == "friction":
        yield part, friction(names)
    elif part == "rounds":
        yield part, rounds(names)
    else:
        size = {"size": SMALL_SIZE, "spacing": SMALL_SPACING} if part == "small" else {}
        agreement = agreed(names, options.out / part, options, **size)
        yield part, pairs(agreement)
        finer = on_half_the_mesh(agreement.learned, options.random) if part == "small" else {}
        yield f"{part}, each", [{**row, **finer.get(row["manipulation"], {})} for row in distances(agreement)]


if __name__ == "__main__":
    main()
