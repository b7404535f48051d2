"""Largest allowed errors of simulators in checks, by simulator and quantity.

A limit states how exact a simulator claims to be. Limits are data, so that another simulator can state its own limits.
A quantity without a limit is printed, but it cannot fail. The unit is a fraction, an SI unit or degrees, as each
comment says.
"""

from __future__ import annotations

NATIVE = {
    # motion
    "fall": 1e-3,  # fraction of the height of the fall
    "momentum": 1e-6,  # fraction of sum m |v|
    "angular momentum": 1e-2,  # fraction of sum m |x| |v|; differences between frames are not more exact
    "energy": 1e-3,  # fraction of the converted energy; energy must never rise by more than errors of the frames
    # air
    "air speed": 1e-3,
    "air path": 2e-3,
    "swing period": 5e-3,
    "swing decrement": 0.01,  # fraction of an excursion that is lost in a swing
    # stretch
    "hang strain": 0.01,
    "hang profile": 0.01,  # fraction of the displacement of the end
    "shear": 0.02,
    "pulled area": 0.02,  # fraction of the change of the area
    "catenary": 0.01,
    # bending
    "chord at 10 mm": 1.0,  # degrees
    "chord at 5 mm": 0.5,  # degrees
    "order": 1.0,  # at least
    "loop height": 0.05,
    # orthotropy
    "off-axis stiffness": 0.03,
    "off-axis chord": 1.0,  # degrees
    # hysteresis
    "residual curvature": 0.3,  # 1/m
    "frictional chord": 1.0,  # degrees
    # contact
    "threshold": 0.2,  # degrees
    "creep": 1e-4,  # m/s
    "acceleration": 0.01,
    "threshold between layers": 1.0,  # degrees
    "layer gap": 0.10,
    "stack creep": 1e-4,  # m in 10 s
    "crossings": 0,
    # rigid bodies
    "capstan": 0.05,
    "carried": 0.02,
    "dragged": 0.05,
    "penetration": 0.1,  # fraction of the thickness
    "drape": 0.5,  # mm, half a thickness
    # mesh
    "rank correlation": 0.95,  # at least
    "best": 2e-3,  # m
    # symmetry and determinism
    "symmetry": 1e-6,  # m, before contact
    "bytes": 0,
}

LIMITS = {"native": NATIVE}
