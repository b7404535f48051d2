"""Runs one scene in Newton: `python newton_worker.py IN.npz OUT.npz`, in Newton's own virtual environment.

IN has `vertices`, `rest`, `faces`, `held` (grippers, n) and `paths` (grippers, steps + 1, 3), `closes` and `opens` as
steps (grippers,), and the JSON string `numbers`. OUT has `positions` (frames, n, 3) and `seconds`. Knows nothing of
tatamu.

SolverVBD on the processor. Newton's numbers: tri_ke and tri_ka are Lame's mu and lambda of a sheet in plane stress, and
edge_ke = B / H with H the height of an equilateral cell, from the energy of a sheet bent to a cylinder averaged over
directions, for Newton's k L theta^2 / 2 per edge.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np
import warp as wp

wp.config.quiet = True
import newton  # noqa: E402

CONTACT = 200.0
"""Stiffness of a contact [N/m]: a vertex at rest sinks in by a hundredth of a millimetre."""


def main(source: str, out: str) -> None:
    data = dict(np.load(source))
    numbers = json.loads(str(data["numbers"]))
    wp.set_device("cpu")
    model = _model(data, numbers)
    _run(model, data, numbers, frames=2)  # compiles
    begin = time.perf_counter()
    positions = _run(model, data, numbers, frames=numbers["frames"])
    np.savez(out, positions=positions, seconds=time.perf_counter() - begin, version=newton.__version__)


def _model(data: dict[str, np.ndarray], numbers: dict[str, float]) -> newton.Model:
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -numbers["gravity"]))
    Y, nu = numbers["stretch_stiffness"], numbers["poisson_ratio"]
    builder.add_cloth_mesh(
        pos=wp.vec3(0.0),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=wp.vec3(0.0),
        vertices=[wp.vec3(*point) for point in data["rest"].tolist()],
        indices=data["faces"].ravel().tolist(),
        density=numbers["areal_density"],
        tri_ke=Y / (2.0 * (1.0 + nu)),
        tri_ka=Y * nu / (1.0 - nu**2),
        tri_kd=0.0,
        edge_ke=numbers["bending_rigidity"] / (np.sqrt(0.75) * numbers["edge"]),
        edge_kd=0.0,
        particle_radius=0.5 * numbers["thickness"],
    )
    builder.color(include_bending=True)
    builder.default_shape_cfg.ke, builder.default_shape_cfg.mu = CONTACT, numbers["friction_table"]
    builder.default_shape_cfg.kd = 0.0
    builder.add_ground_plane()
    model = builder.finalize()
    model.soft_contact_ke, model.soft_contact_kd = CONTACT, 0.0
    model.soft_contact_mu = numbers["friction_cloth"]
    return model


def _run(model: newton.Model, data: dict[str, np.ndarray], numbers: dict[str, float], frames: int) -> np.ndarray:
    t = numbers["thickness"]
    solver = newton.solvers.SolverVBD(
        model,
        iterations=int(numbers["iterations"]),
        particle_enable_self_contact=True,
        particle_self_contact_margin=t,
        particle_self_contact_gap=t,
        collision_pipeline=newton.CollisionPipeline(model, broad_phase="nxn", soft_contact_gap=4 * t),
    )
    now, then, control = model.state(), model.state(), model.control()
    for state in (now, then):
        state.particle_q.numpy()[:] = data["vertices"]
    flags, active = model.particle_flags.numpy(), int(newton.ParticleFlags.ACTIVE)
    flags[:] |= active
    bases: dict[int, np.ndarray] = {}
    out = [data["vertices"]]
    for step in range(int(numbers["substeps"]) * (frames - 1)):
        for hand, held in enumerate(data["held"]):
            holds = data["closes"][hand] <= step < data["opens"][hand]
            flags[held] = flags[held] & ~active if holds else flags[held] | active
            if holds:
                base = bases.setdefault(hand, now.particle_q.numpy()[held].copy())
                now.particle_q.numpy()[held] = base + data["paths"][hand, step + 1]
        now.clear_forces()
        solver.step(now, then, control, None, numbers["step"])
        now, then = then, now
        if (step + 1) % numbers["substeps"] == 0:
            out.append(now.particle_q.numpy().copy())
    return np.array(out, dtype=np.float64)


if __name__ == "__main__":
    main(*sys.argv[1:])
