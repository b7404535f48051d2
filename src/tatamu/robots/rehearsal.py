"""A rehearsal of a plan: the robot's joints are driven along the plan in MuJoCo, with gravity and contacts.

Each joint has position and velocity control. Gravity is compensated, as by a robot's own controller. Contacts act
between every pair of shapes that the plan checked. The cloth is light, so it follows the hands and does not move them.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.robots.extras import needed, one_line
from tatamu.robots.pairs import link_name
from tatamu.robots.planfile import Planned
from tatamu.robots.stage import MODEL, Poser, contacts, data_of, load_stage

STEP = 0.001
"""Time step of the simulation [s]."""
FINGER_PERIOD = 0.01
"""Time between commands to the fingers [s]."""
STIFFNESS, RATIO = 60.0, 1.0
"""Natural frequency [rad/s] and damping ratio of the control that drives the joints.

The frequency is typical of industrial drives.
"""

DRIVES = ("position", "velocity")


@dataclass(frozen=True)
class Contact:
    """A contact of two links of the robot during a rehearsal."""

    links: tuple[str, str]
    first: float
    """Time at which the links first touch [s]."""
    depth: float
    """Maximum penetration depth [m]."""


@dataclass(frozen=True)
class Rehearsal:
    """The result of a rehearsal: the motion of the robot, and its contacts."""

    planned: Planned
    times: np.ndarray
    """Times of the samples [s], shape (n,)."""
    angles: np.ndarray
    """Angles of the plan's j joints at each sample [rad], shape (n, j)."""
    tools: np.ndarray
    """Positions of each tool in the base B [m], shape (arms, n, 3)."""
    wanted_tools: np.ndarray
    """Planned positions of each tool in the base B [m], shape (arms, n, 3)."""
    contacts: list[Contact]
    wall_seconds: float

    @property
    def joint_distances(self) -> np.ndarray:
        """Deviation of each joint from the plan at each sample [rad], shape (n, j)."""
        return self.angles - self.planned.angles_at(self.times)

    @property
    def joint_error(self) -> np.ndarray:
        """Maximum deviation of each joint from the plan [rad], shape (j,)."""
        return np.abs(self.joint_distances).max(axis=0)

    @property
    def closes(self) -> float:
        """Time at which the first hand closes [s]. The rehearsed fold begins at this time."""
        return min(self.planned.event(arm, "close") for arm in self.planned.arms)

    @property
    def tool_distances(self) -> np.ndarray:
        """Distance of each tool from its planned position at each sample [m], shape (arms, n)."""
        return np.asarray(np.linalg.norm(self.tools - self.wanted_tools, axis=2))

    @property
    def tool_error(self) -> float:
        """Maximum distance of a tool from its planned position while it grips the cloth [m]."""
        distance = self.tool_distances
        return float(
            max(distance[number, self.holding(arm)].max(initial=0.0) for number, arm in enumerate(self.planned.arms))
        )

    def holding(self, arm: str) -> np.ndarray:
        """Return for each sample whether it is between the closing and the opening of an arm's jaw, shape (n,)."""
        closes, opens = self.planned.event(arm, "close"), self.planned.event(arm, "open")
        return (self.times >= closes) & (self.times <= opens)

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second of computing time."""
        return float(self.times[-1] / self.wall_seconds)


def rehearse(planned: Planned) -> Rehearsal:
    """Drive the robot along a plan in MuJoCo.

    Raises:
        InputError: If the plan's model cannot be read, or lacks a joint.
    """
    mujoco = needed("mujoco")
    model = _stage(planned, mujoco)
    columns = [int(model.joint(name).qposadr[0]) for name in planned.plan.joints]
    data = data_of(model)
    data.qpos[columns] = planned.angles[0]
    mujoco.mj_forward(model, data)
    finger_times = np.arange(0.0, planned.times[-1] + 2 * FINGER_PERIOD, FINGER_PERIOD)
    fingers = planned.fingers(finger_times)
    finger_drives = [int(model.actuator(f"{joint}_position").id) for joint in fingers]
    drives = [[int(model.actuator(f"{joint}_{kind}").id) for joint in planned.plan.joints] for kind in DRIVES]
    for joint in _others(model, planned):  # these joints keep their positions
        data.actuator(f"{joint}_position").ctrl[0] = data.joint(joint).qpos[0]
    touched: dict[tuple[str, str], Contact] = {}
    samples: list[tuple[float, np.ndarray, np.ndarray]] = []
    begun = time.perf_counter()
    for step, (wanted, speed) in enumerate(_commands(planned)):
        data.ctrl[drives[0]], data.ctrl[drives[1]] = wanted, speed
        due = min(int(data.time / FINGER_PERIOD), len(finger_times) - 1)
        data.ctrl[finger_drives] = [positions[due] for positions in fingers.values()]
        if step % 5 == 0:  # every fifth time step is recorded
            samples.append((data.time, data.qpos[columns].copy(), _tools(data, planned)))
        mujoco.mj_step(model, data)
        _note(model, data, touched)
    wall = time.perf_counter() - begun
    times = np.array([sample[0] for sample in samples])
    poser = Poser(model, planned, planned.angles_at(times), times)
    return Rehearsal(
        planned=planned,
        times=times,
        angles=np.array([sample[1] for sample in samples]),
        tools=np.stack([sample[2] for sample in samples], axis=1),
        wanted_tools=np.stack([_tools(poser.pose(row), planned) for row in range(len(times))], axis=1),
        contacts=list(touched.values()),
        wall_seconds=wall,
    )


def _stage(planned: Planned, mujoco: Any) -> Any:
    """Return the plan's model with drives on its joints."""
    path = planned.folder / MODEL
    spec = load_stage(planned.folder)
    try:
        spec.option.timestep = STEP
        missing = [] if spec.body(planned.plan.base_frame) else [planned.plan.base_frame]
        missing += [f"{arm}_tool" for arm in planned.arms if spec.site(f"{arm}_tool") is None]
        if missing:
            raise ValueError(f"the model does not contain {missing[0]}")
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        model = spec.compile()
        moved = (*planned.plan.joints, *_others(model, planned))
        inertia = _inertia(model, planned, moved, mujoco)
    except (ValueError, KeyError) as error:
        raise InputError(f"{path}: cannot be rehearsed ({one_line(error)})") from None
    for body in spec.bodies:
        body.gravcomp = 1.0
    for joint in spec.joints:  # the robot's controller compensates damping, friction and stiffness
        joint.damping, joint.frictionloss, joint.stiffness = 0 * joint.damping, 0.0, 0 * joint.stiffness
    for gain, kind in zip((STIFFNESS**2, 2 * RATIO * STIFFNESS), DRIVES, strict=True):
        for joint, mass in zip(moved, inertia, strict=True):
            drive = spec.add_actuator(name=f"{joint}_{kind}", target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            getattr(drive, f"set_to_{kind}")(**{"kp" if kind == "position" else "kv": gain * mass})
    return spec.compile()


def _inertia(model: Any, planned: Planned, joints: Sequence[str], mujoco: Any) -> list[float]:
    """Return the inertia at each joint in the pose in the middle of the plan, where the arms hold the cloth."""
    data = data_of(model)
    middle = planned.angles[len(planned.angles) // 2]
    for name, angle in zip(planned.plan.joints, middle, strict=True):
        data.joint(name).qpos[0] = angle
    mujoco.mj_forward(model, data)
    diagonal = model.M_rowadr + model.M_rownnz - 1  # a row of MuJoCo's sparse inertia ends at the diagonal
    dofs = [int(model.joint(name).dofadr[0]) for name in joints]
    return [float(inertia) for inertia in data.M[diagonal[dofs]]]


def _others(model: Any, planned: Planned) -> list[str]:
    """Return the names of the model's joints that the plan does not move."""
    names = [str(model.joint(number).name) for number in range(model.njnt)]
    return [name for name in names if name not in planned.plan.joints]


def _commands(planned: Planned) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the commanded angles and speeds of the joints at every time step."""
    for (early, start), (late, end) in pairwise(zip(planned.times, planned.angles, strict=True)):
        count = max(1, round((late - early) / STEP))
        speed = (end - start) / (late - early)
        for step in range(count):
            yield start + (end - start) * ((step + 1) / count), speed


def _tools(data: Any, planned: Planned) -> np.ndarray:
    """Return the present position of each tool in the base B [m], shape (arms, 3)."""
    base = data.body(planned.plan.base_frame)
    R_WB = base.xmat.reshape(3, 3)
    return np.array([R_WB.T @ (data.site(f"{arm}_tool").xpos - base.xpos) for arm in planned.arms])


def _note(model: Any, data: Any, touched: dict[tuple[str, str], Contact]) -> None:
    """Record which links touch now, the time when they first touched, and the largest penetration depth."""
    for contact in contacts(data):
        if contact.dist <= 0:
            one, other = sorted(link_name(model, int(geom)) for geom in contact.geom)
            known = touched.get((one, other), Contact((one, other), float(data.time), 0.0))
            touched[one, other] = replace(known, depth=max(known.depth, -float(contact.dist)))
