"""The scene of a learned fold in which the hands of a rehearsed robot replace the learned hands.

Time 0 is the time at which the fingers close. Each gripper follows the actual motion of its tool. When a jaw grasps
cloth, the cloth is lifted to the fingertips. If the hands of the learned fold have fingers, the robot's fingers are
rigid bodies in the scene.
"""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.fingers import Fingers, FingerSize
from tatamu.folding.hand import HandPath, finger_bodies
from tatamu.folding.manipulation import HANDS, WAIT, Hand
from tatamu.robots.hands import grippers_by_hand
from tatamu.robots.planfile import JawFile
from tatamu.robots.pose import into
from tatamu.robots.rehearsal import Rehearsal
from tatamu.simulation.body import Body
from tatamu.simulation.scene import Gripper, Scene


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
        raise InputError(f"scene.json: grippers: must be of {len(arms)}, as many as arms fold, given {len(hands)}")
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
