"""A running scene, which `simulate` runs to the end, or a controller advances step by step.

Time advances in outer steps of length H. A scene that is advanced in pieces, or continued from a saved state, has
exactly the same bytes as without interruption.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from functools import cached_property
from math import floor, inf

import numpy as np

from tatamu.base.errors import InputError, SceneError, SimulationError
from tatamu.simulation.mesh.topology import principal_stretches
from tatamu.simulation.native.contact import broad_phase
from tatamu.simulation.native.contact.untangle import untangle
from tatamu.simulation.native.grippers import Grippers, HandTarget
from tatamu.simulation.native.led_bodies import BodyTarget, LedBodies
from tatamu.simulation.native.model import model_of
from tatamu.simulation.native.options import Options
from tatamu.simulation.native.precompile import load
from tatamu.simulation.native.snapshot import Rest, SimulationState, changing
from tatamu.simulation.native.system import Span, initial_system, step_sizes, steps_of
from tatamu.simulation.scene import Scene
from tatamu.simulation.source import source_digest

FRAMES_AT_ONCE = 8
"""Frames between two checks for interrupts such as Ctrl+C, which compiled loops do not notice."""
LOCKED = 3000.0
"""Maximum Y h^2 / B without a warning that the mesh may be too stiff for natural folds [-] (docs/theory/bending.md)."""


class Simulation:
    """A scene that is advanced step by step.

    For example::

        simulation = Simulation(scene)
        while not simulation.done:
            simulation.advance(1 / 60, hands=[HandTarget(displacement=policy(simulation.positions))])

    `number` is the number of outer steps that have been simulated.
    """

    def __init__(self, scene: Scene, options: Options | None = None) -> None:
        """Prepare a scene, or raise SceneError if its cloth is too thick for its mesh, or it would take hours."""
        self.scene = scene
        self.options = options or Options()
        self.model = model_of(scene.cloth, scene.material, self.options)
        self.sizes = step_sizes(scene, self.model, self.options.step)
        self.per_frame = round(1.0 / (scene.frame_rate * self.sizes.outer_step))
        self.steps = steps_of(scene, self.sizes)
        self.number = 0
        self._refuse()
        system = initial_system(scene, self.options)
        self.mesh = system.mesh
        self.contact = system.contact
        self._grippers = Grippers(scene, self.sizes.outer_step, self.steps)
        self._latest = np.empty((FRAMES_AT_ONCE, *scene.cloth.vertices.shape))
        self._loop, kernels = load(system, self._grippers.hands(), self._latest)
        self.system = system._replace(kernels=kernels)
        self._positions = _read_only(self.system.state.positions.x)
        self._velocities = np.empty((3, len(scene.cloth.vertices)))
        self._requested = 0.0
        self._bodies = LedBodies(scene, self.system.bodies, self.sizes.outer_step)
        self._untangle_at = 0  # the initial state may pass through itself, for example if it comes from another mesh
        self._rest = Rest()
        self.search()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.number * self.sizes.outer_step

    @property
    def done(self) -> bool:
        """Whether the scene has ended."""
        return self.number >= self.steps

    @property
    def positions(self) -> np.ndarray:
        """Positions [m], shape (n, 3): a read-only view, which `advance` changes."""
        return self._positions

    @property
    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3): read-only, and filled again at each use."""
        np.take(self.system.state.V, self.model.slot, axis=1, out=self._velocities)
        return _read_only(self._velocities.T)

    @property
    def closed(self) -> tuple[bool, ...]:
        """Whether each gripper of the scene holds something."""
        return self._grippers.closed

    @property
    def displacements(self) -> np.ndarray:
        """Displacement of each gripper since it closed [m], shape (grippers, 3); zero if it is open."""
        return self._grippers.displacements(self.number)

    @property
    def substeps(self) -> int:
        """Number of membrane steps that have been simulated."""
        return self.number * self.sizes.kicks * self.sizes.substeps_per_kick

    def advance(
        self,
        seconds: float,
        hands: Sequence[HandTarget | None] | None = None,
        bodies: Sequence[BodyTarget | None] | None = None,
    ) -> None:
        """Simulate for a time [s] of at least one outer step, and end at the step nearest to the total of all calls.

        `hands` and `bodies` are targets in the order of the scene, where None means no new target. Until its first
        target, a gripper or body follows the scene. At a target, a gripper opens or closes immediately; then it moves,
        or a body moves and turns, at constant velocity, reaches the target at the end of this call, and stays there.

        Raises:
            InputError: If an argument is wrong. Nothing is simulated.
            SimulationError: If the cloth exceeded one of the limits in `LimitOptions`.
        """
        step = self.sizes.outer_step
        if self.done:
            raise InputError(
                f"seconds: the scene has already ended at {self.time:.6g} s; give the scene a longer duration"
            )
        if not step <= seconds < inf:
            raise InputError(f"seconds: must be finite and at least one outer step ({step:.3g} s), given {seconds}")
        requested = min(self._requested + seconds, self.scene.duration)
        stop = max(self.number, min(self._step_at(requested), self.steps))
        count = len(self.scene.grippers)
        hands = [None] * count if hands is None else hands
        if len(hands) != count:
            raise InputError(f"hands: must have one item for each of {count} grippers, given {len(hands)}")
        fastest = self.options.limits.fastest_hand
        poses = {} if bodies is None else self._bodies.check(bodies, self.number, stop, fastest)
        self._grippers.lead(hands, self.number, stop, fastest)
        self._bodies.lead(poses, self.number, stop)
        self._requested = requested
        while self.number < stop:
            self._advance_to(stop)

    def state(self) -> SimulationState:
        """Return a copy, which can be pickled, of everything on which the rest of the rollout depends."""
        return SimulationState(
            digest=self._digest,
            number=self.number,
            requested=self._requested,
            untangle_at=self._untangle_at,
            rest=self._rest,
            grippers=self._grippers.state(),
            bodies=self._bodies.state(),
            arrays=tuple(array.copy() for array in changing(self.system)),
        )

    def restore(self, state: SimulationState) -> None:
        """Set the simulation to a saved state, or raise InputError if its scene, options or version differ."""
        if state.digest != self._digest:
            raise InputError("state: must come from a simulation with the same scene, options and version of tatamu")
        self.number = state.number
        self._requested = state.requested
        self._untangle_at = state.untangle_at
        self._rest = state.rest
        self._grippers.restore(state.grippers)
        self._bodies.restore(state.bodies)
        for array, saved in zip(changing(self.system, state.arrays[0]), state.arrays, strict=True):
            array[...] = saved

    def __reduce__(self) -> tuple[Callable[..., Simulation], tuple[Scene, Options, SimulationState]]:
        """Copy and pickle by scene, options and state, without the compiled code."""
        return _restored, (self.scene, self.options, self.state())

    def frames(self) -> np.ndarray:
        """Simulate from start to end, and return the positions in all frames [m], shape (f, n, 3)."""
        x = self.system.state.positions.x
        size = self.scene.frames * x.nbytes
        single = size > self.options.limits.most_bytes_in_double
        frames = np.empty((self.scene.frames, *x.shape), dtype=np.float32 if single else float)
        frames[0] = x
        last = (self.scene.frames - 1) * self.per_frame
        while self.number < last:
            begin = self.number // self.per_frame + 1
            self._advance_to(last)
            reached = self.number // self.per_frame + 1
            frames[begin:reached] = self._latest[: reached - begin]
        return frames

    @cached_property
    def _digest(self) -> str:
        text = f"{self.scene.model_dump_json()}{self.options!r}{source_digest()}"
        return hashlib.sha256(text.encode()).hexdigest()

    def _step_at(self, time: float) -> int:
        return floor(time / self.sizes.outer_step + 0.5)

    def _advance_to(self, last: int) -> None:
        """Advance to outer step `last`, but at most to the next event, and at most by FRAMES_AT_ONCE frames.

        At an event, a gripper opens or closes, layers are separated, or rest is tested. `_latest` receives the frames.
        """
        self._work_grippers()
        end = min(last, self.number + FRAMES_AT_ONCE * self.per_frame)
        if self._rest.reached:
            self._latest[:] = self.system.state.positions.x
            self.number = end
            return
        events = [self._untangle_at, self._rest.look_at, *self._grippers.events()]
        stop = min([end, *(number for number in events if number > self.number)])
        span = Span(self.number, stop, self.per_frame)
        self.number, stretch = self._loop(self.system, self._grippers.hands(), self._latest, span)
        self._check(stretch, self.number < stop)

    def search(self) -> None:
        """Search for candidates for contact; layers must not have passed through each other."""
        system = self.system
        broad_phase.search(system.state.positions.x, system.mesh, system.contact, system.options, system.kernels)

    def warnings(self) -> list[str]:
        """Return warnings about this rollout for the user, one per line."""
        lines = []
        if self.mesh.thickness > 0.5 * self.model.lengths.min():
            lines.append(
                "thickness is more than half the shortest edge of the mesh, so neighbouring triangles may "
                "push each other apart; give a coarser mesh"
            )
        material, edge = self.scene.material, float(self.model.lengths.mean())
        rigidity = min(material.bending_rigidity, material.weft_rigidity)
        stiffness = max(material.stretch_stiffness, material.weft_stiffness)
        ratio = stiffness * edge * edge / rigidity if rigidity > 0.0 else inf  # Y h^2 / B, stretching against bending
        if LOCKED < ratio < inf:
            finer = 0.88e3 * edge * np.sqrt(LOCKED / ratio)  # edges are up to 7 % longer than the spacing, and rounded
            lines.append(
                f"the cloth may drape too stiffly, because the mesh is coarse (Y h^2 / B is {ratio:.2g}, more "
                f"than {LOCKED:g}); give a spacing of {finer:.2g} mm, or a smaller stretch_stiffness"
            )
        duration, rate = self.scene.duration, self.scene.frame_rate
        if self.scene.frames == 1:
            shown = f"{duration:g} s; give a duration of at least {np.ceil(1e6 / rate) / 1e6:g} s"
            lines.append(f"the rollout contains only the first frame, because the scene lasts {shown}")
        for number, gripper in enumerate(self.scene.grippers):
            missing = np.linalg.norm(gripper.displacements[-1] - gripper.displacement(duration))
            if gripper.times[-1] > duration and missing > 1e-3:
                lines.append(
                    f"grippers.{number}: the motion lasts until {gripper.times[-1]:g} s, but the scene ends at "
                    f"{duration:g} s; check that all times are in seconds, or give a longer duration"
                )
        return lines

    def _work_grippers(self) -> None:
        """Open and then close grippers, so that one can grasp cloth that another releases in the same step."""
        if not self._grippers.is_due(self.number) and self.number not in (self._untangle_at, self._rest.look_at):
            return
        opened = self._grippers.open_due(self.number)
        for vertices in opened:
            self._set_free(vertices, 1.0)
        if opened or self.number == self._untangle_at:
            self._untangle()
        taken = self._grippers.close_due(self.number, self.system.state.positions.x)
        for vertices in taken:
            self._set_free(vertices, 0.0)
        if taken:
            self._rest = Rest()
        elif opened or self.number == self._rest.look_at:
            self._look_for_rest()

    def _look_for_rest(self) -> None:
        """Test whether the cloth is at rest, after which it does not move until a hand grasps it."""
        later = any(number > self.number for number in self._grippers.events())
        if later or any(self.closed) or self.scene.bodies:
            self._rest = Rest()
            return
        options = self.options.rest
        wait = max(1, self._grippers.step_at(options.every))
        self._rest = self._rest.looked(self.number, self.system.state.positions.x, wait, options.still)
        if self._rest.reached:
            self.system.state.V[:] = 0.0

    def _untangle(self) -> None:
        """Separate layers that have passed through each other, and search candidates again.

        Another attempt follows if layers are still crossed, because the cloth may move until then, or if they were
        separated, because they can cross again.
        """
        x = self.system.state.positions.x
        apart, left = untangle(x, self.mesh, self.model.lengths, self.options.untangle)
        wait = max(1, self._grippers.step_at(self.options.untangle.again_after))
        self._untangle_at = self.number + wait if left or apart is not x else -1
        if apart is not x:
            x[:] = apart
            self.system.state.X[:, self.system.state.slot] = apart.T
            self.search()

    def _set_free(self, vertices: np.ndarray, free: float) -> None:
        slot = self.model.slot[vertices]
        inverse_mass = free / self.model.mass[vertices]
        self.system.state.free[slot] = free
        self.system.state.inverse_mass[slot] = inverse_mass
        self.mesh.inverse_mass[vertices] = inverse_mass

    def _check(self, stretch: float, stopped: bool) -> None:
        time = self.number * self.sizes.outer_step
        limits = self.options.limits
        if not stopped and stretch <= limits.largest_stretch:
            return
        recent = 0.1  # a hand that moved too fast within this time before the error counts as its cause [s]
        if time < recent:  # explicit steps may be unstable if the cloth is stretched at the start
            cloth = self.scene.cloth
            stretches = principal_stretches(cloth.vertices, cloth.rest, cloth.faces)
            worst = int(stretches.argmax())
            if not stretches[worst] <= limits.largest_stretch:
                raise SceneError(
                    f"cloth.vertices: must not stretch a triangle to more than {limits.largest_stretch:g} times "
                    f"its size in rest_vertices, given {stretches[worst]:.3g} times in triangle {worst}"
                )
        index, speed, when = self._grippers.fastest(self.number + 1, self._step_at(recent))
        if speed > limits.fastest_hand:
            raise SceneError(
                f"grippers.{index}: must not move faster than {limits.fastest_hand:g} m/s, given {speed:.3g} m/s at t "
                f"= {when:.3f} s; robot arms move at up to 2 m/s"
            )
        if stretch > limits.largest_stretch:
            raise SimulationError(
                f"the cloth was stretched to {stretch:.3g} times its length at t = {time:.3f} s; the limit is "
                f"{limits.largest_stretch:g}"
            )
        raise SimulationError(f"the cloth flew beyond {limits.farthest:g} m before t = {time:.3f} s")

    def _refuse(self) -> None:
        """Raise SceneError if the scene cannot be simulated."""
        thickness = self.model.mesh.thickness
        shortest = float(self.model.lengths.min())
        limits = self.options.limits
        if thickness > limits.thickest * shortest:
            raise SceneError(
                f"thickness must be at most {limits.thickest:g} times the shortest edge ({shortest:.3g} m), "
                f"given {thickness:g} m; give a coarser mesh"
            )
        work = self.steps * self.sizes.kicks * self.sizes.substeps_per_kick * len(self.model.mass)
        if work > limits.most_work:
            raise SceneError(
                f"the scene needs {work:.2g} vertex steps, more than the limit of {limits.most_work:g}, and would take "
                "hours; give a coarser mesh or a shorter duration"
            )


def _restored(scene: Scene, options: Options, state: SimulationState) -> Simulation:
    simulation = Simulation(scene, options)
    simulation.restore(state)
    return simulation


def _read_only(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.setflags(write=False)
    return view
