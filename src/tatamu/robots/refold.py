"""Simulate the learned fold again: by the robot's hands as they moved in the rehearsal, and by floating hands.

Floating hands move exactly as learned, without a robot. A simulator may need a finer mesh, which has all vertices of
the learned mesh, so shapes are always compared and scored on the learned mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.fingers import Fingers, FingerSize
from tatamu.folding.hand import HandPath, finger_bodies
from tatamu.folding.manipulation import HANDS, WAIT, Hand
from tatamu.folding.score import Score
from tatamu.robots.hands import grippers_by_hand
from tatamu.robots.planfile import JawFile
from tatamu.robots.pose import into
from tatamu.robots.rehearsal import Rehearsal
from tatamu.simulation.body import Body
from tatamu.simulation.mesh.meshing import before_subdivision, subdivided
from tatamu.simulation.mesh.topology import Topology, edge_lengths
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Gripper, Scene
from tatamu.simulation.simulators import capabilities, named
from tatamu.study.result import Result


@dataclass(frozen=True)
class Refold:
    """Two simulated motions of one fold, on the mesh of the learned fold."""

    simulator: str
    halvings: int
    """Number of times that the edges of the learned mesh were halved for the simulation."""
    simulated_vertices: int
    scene: Scene
    """The scene with the robot's hands."""
    robot: Rollout
    floating: Rollout
    """The fold by floating hands. The hands move at the learned speed, which may be higher than the robot's speed."""
    target: np.ndarray | None
    """The wanted positions of all n vertices [m], shape (n, 3); None if the plan does not contain these positions."""
    learned: Result | None = None
    """The learned fold with its task, which is needed to score folds; None if the fold cannot be scored."""
    unscored: str | None = None
    """Reason why the fold cannot be scored; None if the fold can be scored."""

    @property
    def apart(self) -> np.ndarray:
        """Distance of each vertex between the final shapes of both folds [m], shape (n,).

        One fold is by the robot's hands, the other fold is by floating hands.
        """
        return np.asarray(np.linalg.norm(self.robot.positions[-1] - self.floating.positions[-1], axis=1))

    @property
    def scores(self) -> dict[str, Score]:
        """Scores of three folds: by the robot, by floating hands, and the learned fold.

        Empty if they cannot be scored.
        """
        if self.learned is None:
            return {}
        return {
            "robot": self.learned.rate(self.robot.positions[-1]),
            "floating": self.learned.rate(self.floating.positions[-1]),
            "learned": self.learned.score,
        }


def halvings_for(scene: Scene, simulator: str) -> int:
    """Return how many times, at most twice, the edges of a scene's mesh must be halved for a simulator."""
    largest = capabilities(simulator).usable_cell or np.inf
    lengths = edge_lengths(scene.cloth.rest, Topology(scene.cloth.faces).edges)
    cells = lengths.mean() / max(scene.material.bending_length, 1e-9)
    needed = int(np.ceil(np.log2(max(cells / largest, 1e-9))))
    return min(max(0, needed), 2)


def refold(rehearsal: Rehearsal, simulator: str, halvings: int | None = None) -> Refold | None:
    """Simulate the fold with the robot's hands and with floating hands. Return None if the plan contains no scene.

    Args:
        rehearsal: Motion of the robot.
        simulator: Name of the simulator.
        halvings: Number of times that the mesh's edges are halved; None for the number that the simulator needs.

    Raises:
        InputError: If no simulator has this name, or a file of the fold is broken.
        SimulationError: If the simulation failed.
    """
    folder = rehearsal.planned.fold
    if not folder.scene_file.is_file():
        return None
    learned = folder.scene
    engine = named(simulator)
    scene = rehearsed_scene(rehearsal, learned)
    count = halvings_for(learned, simulator) if halvings is None else halvings
    both = [subdivided(one, count) for one in (scene, learned)]
    robot, floating = (before_subdivision(fine, learned.cloth.faces) for fine in engine.simulate_many(both))
    known: Result | None = None
    why_not: str | None = "the plan contains no result.json of the learned fold"
    if folder.result_file.is_file():
        try:
            known, why_not = Result.load(folder.path), None
        except InputError as error:
            why_not = str(error)
    target = folder.rollout.extra.get("target") if folder.rollout_file.is_file() else None
    if target is not None and target.shape != (len(learned.cloth.vertices), 3):
        target = None
    return Refold(simulator, count, len(both[0].cloth.vertices), scene, robot, floating, target, known, why_not)


def rehearsed_scene(rehearsal: Rehearsal, learned: Scene) -> Scene:
    """Return the scene of a fold by the robot's hands.

    While the fingers close, all grippers of a hand are lifted by the same height. If a hand has several grippers, the
    other grippers are also pressed onto the first gripper.

    Args:
        rehearsal: Motion of the robot.
        learned: The scene of the learned fold, with the left hand's grippers first.

    Raises:
        InputError: If the number of hands in the scene is not the number of arms that fold.
    """
    hands = grippers_by_hand(learned)
    arms = rehearsal.planned.arms
    if len(hands) != len(arms):
        raise InputError(
            f"scene.json: grippers: must have one item for each of {len(arms)} folding arms, given {len(hands)}"
        )
    grippers: list[Gripper] = []
    bodies: list[Body] = []
    for number, (arm, name, hand) in enumerate(zip(arms, HANDS, hands, strict=False)):
        made = _HandOfRobot(rehearsal, number, arm)
        raised = made.raised(learned, hand[0])
        grippers += [made.gripper(one, one.displacements[-1] - hand[0].displacements[-1] + raised) for one in hand]
        bodies += made.fingers(name, learned, hand)
    ends = [gripper.opens for gripper in learned.grippers if gripper.opens is not None]
    rest = max(1.0, learned.duration - max(ends, default=learned.duration))
    opens = max(rehearsal.planned.event(arm, "open") for arm in arms)
    changed = {"grippers": grippers, "bodies": bodies, "duration": opens - rehearsal.closes + rest}
    return learned.model_copy(update=changed)


class _HandOfRobot:
    """One hand of the robot from the closing to the opening of its jaw, in the fold's frame."""

    def __init__(self, rehearsal: Rehearsal, number: int, arm: str) -> None:
        planned = rehearsal.planned
        rows = np.flatnonzero(rehearsal.holding(arm))[::2]
        self._closes, self._opens = (planned.event(arm, event) - rehearsal.closes for event in ("close", "open"))
        self._times = rehearsal.times[rows] - rehearsal.closes
        self._tools = into(planned.plan.task_in_base.matrix, rehearsal.tools[number, rows])
        self._jaw: JawFile | None = planned.plan.jaws.get(arm)

    def raised(self, learned: Scene, gripper: Gripper) -> np.ndarray:
        """Return the displacement by which the jaw lifts the cloth at the grasp [m], shape (3,)."""
        if self._jaw is None:
            return np.zeros(3)
        lies = learned.cloth.vertices[gripper.vertices][:, 2].mean()
        return np.array([0.0, 0.0, self._tools[0, 2] - lies])

    def gripper(self, learned: Gripper, taken: np.ndarray) -> Gripper:
        """Return a gripper that moves with the tool. While the fingers close, its vertices also move by `taken` [m]."""
        share = np.clip((self._times - self._times[0]) / WAIT, 0.0, 1.0)[:, None]
        return Gripper(
            hand=learned.hand,
            vertices=learned.vertices,
            closes=self._closes,
            opens=self._opens,
            times=(self._times + 1e-9).tolist(),
            displacements=self._tools - self._tools[0] + share * taken,
        )

    def fingers(self, name: Hand, learned: Scene, grippers: list[Gripper]) -> list[Body]:
        """Return the two fingers as bodies with the robot's sizes and tilt; none if the learned hand has no fingers."""
        known = [body for body in learned.bodies if body.hand == name]
        if not known or self._jaw is None:
            return []
        shape = Fingers(
            **{name: getattr(self._jaw, name) for name in FingerSize.model_fields},
            tilt=np.pi / 2 - self._jaw.tilt,
            friction=known[0].friction,
        )
        moved = (self._tools[-1] - self._tools[0])[:2]
        heading = np.arctan2(moved[1], moved[0]) + self._jaw.yaw
        held = learned.cloth.vertices[[vertex for one in grippers for vertex in one.vertices]][:, 2]
        path = HandPath(self._times, self._tools, self._closes + WAIT, self._opens)
        normal = np.array([np.cos(heading), np.sin(heading)])
        return finger_bodies(name, shape, normal, float(np.ptp(held)) + learned.material.thickness, path)
