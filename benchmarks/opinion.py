"""Figures of docs/second-opinion.md: how far simulators agree on the default towel, and friction of moving layers.

    python benchmarks/opinion.py --out runs/opinion [--simulators native,blender,mujoco] [--random 10] [--write-docs]

Half an hour of processor time in Blender, as much in MuJoCo. What is there already is not run again.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import numpy as np

from tatamu.files import write_text
from tatamu.folding.task import make_task
from tatamu.garments.fabrics import TERRY
from tatamu.garments.towel import staggered_rectangle
from tatamu.learning import learn
from tatamu.opinion.agreement import Agreement, compare
from tatamu.opinion.learned import read_learned
from tatamu.opinion.matrix import HEAD, pair_cells, save
from tatamu.scene import Cloth, Gripper, Scene, Table
from tatamu.simulators import simulate
from tatamu.topology import areas, lumped

GRAVITY = 9.81
START = 0.05
"""When the upper sheet begins to be drawn [s]."""


def drawn(mu: float, speed: float) -> tuple[Scene, int, float]:
    """A sheet drawn over another on a table without friction: scene, vertices of the lower one, m_upper / m_lower."""
    (lower, faces), (upper, more) = staggered_rectangle(0.12, 0.5, 0.013), staggered_rectangle(0.09, 0.2, 0.013)
    thickness = TERRY.thickness
    vertices = np.concatenate([lower, upper - np.array([0.1, 0.0, -thickness])]) + np.array([0.0, 0.0, thickness / 2])
    faces = np.concatenate([faces, more + len(lower)])
    front = len(lower) + np.flatnonzero(upper[:, 0] > upper[:, 0].max() - 1e-6)
    hand = Gripper(
        vertices=front.tolist(), times=[START, START + 1.0], displacements=np.array([[0.0, 0, 0], [speed, 0, 0]])
    )
    scene = Scene(
        cloth=Cloth(vertices=vertices, faces=faces),
        material=TERRY.model_copy(update={"friction_table": 0.0, "friction_cloth": mu, "air_drag": 0.0}),
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


def friction_table(simulators: list[str]) -> str:
    """Friction of moving layers over Coulomb's, as a Markdown table."""
    cases = [(mu, speed) for mu in (0.2, 0.5) for speed in (0.3, 1.0)]
    lines = ["| lower sheet's acceleration over Coulomb's | " + " | ".join(simulators) + " |"]
    lines.append("|---|" + "---|" * len(simulators))
    for mu, speed in cases:
        cells = " | ".join(f"{carried(name, mu, speed):.2f}" for name in simulators)
        lines.append(f"| mu = {mu:g}, {speed:g} m/s | {cells} |")
    return "\n".join(lines)


def agreement_table(agreement: Agreement) -> str:
    """Pairs of simulators, then all manipulations, as Markdown tables."""
    lines = ["| " + " | ".join(HEAD) + " |", "|---|" + "---|" * (len(HEAD) - 1)]
    lines += ["| " + " | ".join(pair_cells(pair)) + " |" for pair in agreement.pairs]
    lines += ["", "Mean vertex distance from the target [mm] of each manipulation:", ""]
    lines += ["| manipulation | " + " | ".join(agreement.simulators) + " |"]
    lines += ["|---|" + "---|" * len(agreement.simulators)]
    for name in agreement.manipulations:
        scores = [agreement.entries[name, simulator].score for simulator in agreement.simulators]
        cells = [f"{1e3 * score.mean_vertex_distance:.1f}" if score else "failed" for score in scores]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def insert(mark: str, table: str) -> None:
    """Put a table between marks of docs/second-opinion.md."""
    path = Path("docs/second-opinion.md")
    pattern = rf"(<!-- {mark} -->\n).*?(<!-- end -->)"
    write_text(path, re.sub(pattern, lambda found: f"{found[1]}{table}\n{found[2]}", path.read_text(), flags=re.S))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--simulators", default="native,blender,mujoco")
    parser.add_argument("--random", type=int, default=10)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    names = options.simulators.split(",")
    friction = friction_table(names)
    print(friction, flush=True)
    learn(make_task("towel"), options.out / "towel", trials=15, seed=0)
    learned = read_learned(options.out / "towel")
    told = lambda manipulation, simulator: print(manipulation, "in", simulator, flush=True)  # noqa: E731
    agreement = compare(learned, names, options.out / "agreement", count=options.random, progress=told)
    save(agreement, options.out / "agreement")
    print(agreement_table(agreement))
    if options.write_docs:
        insert("friction", friction)
        insert("agreement", agreement_table(agreement))


if __name__ == "__main__":
    main()
