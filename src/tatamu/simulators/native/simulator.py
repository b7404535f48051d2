"""From a Scene to a Rollout."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from time import perf_counter

import numpy as np

from tatamu import __version__
from tatamu.errors import SimulationError
from tatamu.material import Material
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Gripper, Scene, Table
from tatamu.simulators.many import side_by_side
from tatamu.simulators.native.contact import broad_phase as candidates
from tatamu.simulators.native.contact.untangle import untangle
from tatamu.simulators.native.memory.bands import BLOCK, blocks
from tatamu.simulators.native.model import DENSEST_PAIRS, Model, model_of, steps_per_frame, substeps
from tatamu.simulators.native.step import Hands, State, World, advance

LARGEST_STRETCH = 1.5
"""Edges longer than this times their rest length end the rollout: the membrane model means nothing there."""
FARTHEST = 1e4
"""Cloth farther than this from the origin ends the rollout [m]."""
THICKEST = 0.9
"""Thickness is refused beyond this part of the shortest edge."""
FRAMES_AT_ONCE = 8
"""Frames between two looks at what else goes on."""
UNTANGLED_AGAIN = 0.1
"""So long after layers were not taken apart it is tried again [s]."""
MOST_IN_DOUBLE = 64e6
"""Frames that take more bytes are kept in single precision, which rounds a meter by 0.06 micrometers."""
MOST_WORK = 1e12
"""Steps of a vertex that a rollout may need: about two hours."""


def simulate(scene: Scene) -> Rollout:
    """Run one scene.

    Raises:
        SimulationError: The cloth was stretched beyond `LARGEST_STRETCH` or flew away.
    """
    started = perf_counter()
    _load_kernels()
    run = _Run(scene)
    setup = perf_counter() - started
    positions = run.frames()
    info = {
        "simulator": "native",
        "version": __version__,
        "wall_seconds": perf_counter() - started - setup,
        "setup_seconds": setup,
        "steps": run.number,
        "substeps": run.number * run.bends * run.stretches,
        "warnings": run.warnings(),
    }
    return Rollout(np.arange(scene.frames) / scene.frame_rate, positions, np.array(scene.cloth.faces), info)


def simulate_many(scenes: Sequence[Scene]) -> list[Rollout]:
    """Run several scenes, as many at a time as there are processors; the compiled loops let one another run.

    Raises:
        SimulationError: Of the first scene that failed, in the order given.
    """
    return side_by_side(simulate, scenes)


@cache
def _load_kernels() -> None:
    """Compile what is compiled, or read it from disk: a moment of two triangles, once per process."""
    corners = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]]
    material = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5)
    hand = Gripper(vertices=[0], times=[0.0], displacements=np.zeros((1, 3)), opens=0.01)
    cloth = Cloth(vertices=np.array(corners), faces=np.array([[0, 1, 2], [0, 2, 3]]))
    _Run(Scene(cloth=cloth, material=material, table=Table(), grippers=[hand], duration=0.02)).frames()


class _Run:
    """One rollout under way."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.model = model_of(scene.cloth, scene.material)
        self.per_frame = steps_per_frame(scene.frame_rate)
        self.step = 1.0 / (scene.frame_rate * self.per_frame)
        self.bends, self.stretches = substeps(self.model, self.step)
        self.mesh = self.model.mesh._replace(inverse_mass=self.model.mesh.inverse_mass.copy())
        self.state = _state(scene, self.model)
        self.lists = _lists(self.mesh)
        self.world = _world(scene)
        self.number = 0
        self.again = -1
        self._refuse()
        self.closed: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self.paths = self._paths()
        candidates.search(self.state.x, self.mesh, self.lists)

    def frames(self) -> np.ndarray:
        """All frames, shape (f, n, 3)."""
        count = self.scene.frames
        size = count * self.state.x.nbytes
        positions = np.empty((count, *self.state.x.shape), dtype=float if size <= MOST_IN_DOUBLE else np.float32)
        positions[0] = self.state.x
        while self.number < (count - 1) * self.per_frame:
            self._work_grippers()
            self._advance(positions)
        return positions

    def warnings(self) -> list[str]:
        """What the user should know of this rollout."""
        if self.model.thickness > 0.5 * self.model.shortest:
            return ["the cloth is thicker than half its shortest edge: neighbouring triangles may push each other"]
        return []

    def _advance(self, positions: np.ndarray) -> None:
        """Go on until something happens, or for a few frames: compiled loops hear no interrupt."""
        end = min((len(positions) - 1) * self.per_frame, self.number + FRAMES_AT_ONCE * self.per_frame)
        stop = min([end, *(n for n in self._events() if n > self.number)])
        pace, limits = (self.step, self.bends, self.stretches), (LARGEST_STRETCH, FARTHEST)
        work = (self.state, self.model.elastic, self.mesh, self.lists, self._hands(), self.world)
        latest, begin = np.empty((FRAMES_AT_ONCE, *self.state.x.shape)), self.number // self.per_frame + 1
        self.number, stretch = advance(*work, latest, self.per_frame, self.number, stop, pace, limits)
        reached = self.number // self.per_frame + 1
        positions[begin:reached] = latest[: reached - begin]
        self._check(stretch, self.number < stop)

    def _events(self) -> list[int]:
        grippers = self.scene.grippers
        return [self.again, *(self._at(time) for g in grippers for time in (g.closes, g.opens) if time is not None)]

    def _at(self, time: float) -> int:
        """Outer step at which something at `time` happens."""
        return round(min(time, 2 * self.scene.duration) / self.step)

    def _paths(self) -> np.ndarray:
        count = (self.scene.frames - 1) * self.per_frame + 1
        times = np.arange(count) * self.step
        paths = np.zeros((max(len(self.scene.grippers), 1), count, 3))
        for path, gripper in zip(paths, self.scene.grippers, strict=False):
            path[:] = gripper.path(times)
        return paths

    def _work_grippers(self) -> None:
        """Open, then close grippers that are due: one may take at once what another lets go."""
        wanted = {number for number, gripper in enumerate(self.scene.grippers) if self._holds(gripper)}
        due = self.closed.keys() - wanted
        for number in sorted(due):
            self._set_free(self.closed.pop(number)[0], 1.0)
        if due or self.number == self.again:
            self._untangle()
        for number in sorted(wanted - self.closed.keys()):
            vertices = np.array(self.scene.grippers[number].vertices)
            self.closed[number] = (vertices, self.state.x[vertices].copy())
            self._set_free(vertices, 0.0)

    def _holds(self, gripper: Gripper) -> bool:
        """Whether a gripper is closed in the coming step."""
        over = gripper.opens is not None and self._at(gripper.opens) <= self.number
        return self._at(gripper.closes) <= self.number and not over

    def _untangle(self) -> None:
        """Take apart layers that went through one another in a pinch; what is near is then found anew.

        What does not come apart at once may do so when the cloth has moved on.
        """
        mesh, state = self.mesh, self.state
        apart, left = untangle(state.x, mesh, self.model.lengths)
        self.again = self.number + self._at(UNTANGLED_AGAIN) if left else -1
        if apart is not state.x:
            state.x[:] = apart
            state.X[:, state.slot] = apart.T
            candidates.search(state.x, mesh, self.lists)

    def _set_free(self, vertices: np.ndarray, free: float) -> None:
        slot = self.model.slot[vertices]
        inverse = free / self.model.mass[vertices]
        self.state.free[slot], self.state.inverse_mass[slot] = free, inverse
        self.mesh.inverse_mass[vertices] = inverse

    def _hands(self) -> Hands:
        if not self.closed:
            return Hands(np.empty(0, np.int64), np.empty((0, 3)), np.empty(0, np.int64), self.paths)
        gripper = np.concatenate([np.full(len(v), number) for number, (v, _) in self.closed.items()])
        vertex = np.concatenate([vertices for vertices, _ in self.closed.values()])
        base = np.concatenate([positions for _, positions in self.closed.values()])
        return Hands(vertex, base, gripper, self.paths)

    def _check(self, stretch: float, stopped: bool) -> None:
        time = self.number * self.step
        if stretch > LARGEST_STRETCH:
            raise SimulationError(
                f"the cloth was stretched to {stretch:.3g} of its length by t = {time:.3f} s; "
                f"the limit is {LARGEST_STRETCH:g}"
            )
        if stopped or not stretch <= LARGEST_STRETCH:
            raise SimulationError(f"the cloth flew beyond {FARTHEST:g} m before t = {time:.3f} s")

    def _refuse(self) -> None:
        """Refuse what cannot end well."""
        if self.model.thickness > THICKEST * self.model.shortest:
            raise SimulationError(
                f"the cloth is {self.model.thickness:g} m thick, its shortest edge {self.model.shortest:.3g} m long; "
                f"neighbours would push one another apart beyond {THICKEST:g} of an edge: give a coarser mesh"
            )
        work = (self.scene.frames - 1) * self.per_frame * self.bends * self.stretches * len(self.model.mass)
        if work > MOST_WORK:
            raise SimulationError(
                f"the scene needs {work:.2g} steps of a vertex, the limit is {MOST_WORK:g} (hours); stiff, light "
                "or finely meshed cloth takes small steps: give a coarser mesh or a shorter duration"
            )


def _state(scene: Scene, model: Model) -> State:
    count, elastic = len(scene.cloth.vertices), model.elastic
    X = np.zeros((3, model.width))
    X[:, model.slot] = scene.cloth.vertices.T
    inverse_mass, free = np.zeros(model.slots), np.zeros(model.slots)
    inverse_mass[model.slot], free[model.slot] = 1.0 / model.mass, 1.0
    x = np.array(scene.cloth.vertices, order="C")
    return State(
        X=X,
        V=np.zeros((3, model.slots)),
        Y=np.zeros_like(X),
        F=np.zeros_like(X, dtype=np.float32),
        forces=np.zeros(9 * BLOCK, dtype=np.float32),
        H=np.zeros((blocks(elastic.hinges), 8 * BLOCK), dtype=np.float32),
        bend=np.zeros((3, len(elastic.rest_moment) + len(elastic.curl_copies)), dtype=np.float32),
        x=x,
        before=np.empty((count, 3)),
        moved=np.empty((count, 3)),
        inverse_mass=inverse_mass,
        free=free,
        slot=model.slot,
        rounds=np.ones(1, dtype=np.int64),
    )


def _lists(mesh: candidates.Mesh) -> candidates.Lists:
    count, room = len(mesh.inverse_mass), DENSEST_PAIRS * len(mesh.edges)
    return candidates.Lists(
        face=np.full((count, candidates.SLOTS), -1),
        side=np.zeros((count, candidates.SLOTS), dtype=np.int64),
        order=np.arange(count),
        ordered=np.zeros(1, dtype=np.int64),
        wake=np.zeros((count, candidates.SLOTS)),
        pairs=np.empty((room, 4), dtype=np.int64),
        pair_wake=np.empty(room),
        used=np.zeros(1, dtype=np.int64),
        pressed=np.zeros(count, dtype=np.int64),
        call=np.zeros(1, dtype=np.bool_),
        touched=np.zeros(count, dtype=np.int64),
        sweeps=np.zeros(1, dtype=np.int64),
        anchor_face=np.full((count, candidates.SLOTS), -1),
        anchor=np.zeros((count, candidates.SLOTS, 3)),
        travelled=np.zeros(1),
        due=np.zeros(1),
        built=np.zeros((count, 3)),
        restless=np.zeros(count, dtype=np.int64),
        number=np.zeros(1, dtype=np.int64),
    )


def _world(scene: Scene) -> World:
    material, table = scene.material, scene.table
    tilt = table.tilt if table else 0.0
    return World(
        gravity=scene.gravity,
        drag=material.air_drag / material.areal_density,
        friction_cloth=material.friction_cloth,
        friction_table=material.friction_table,
        has_table=table is not None,
        height=table.height if table else 0.0,
        sine=float(np.sin(tilt)),
        cosine=float(np.cos(tilt)),
        half_thickness=0.5 * material.thickness,
    )
