"""Conversion of a material from SI units to Blender's own numbers.

Each relation is derived and measured in docs/theory/blender.md.

Blender multiplies gravity by 0.001 and counts time in frames. Its unit of time is therefore sqrt(0.001) s = 31.6 ms. If
k and m are a stiffness and a mass in Blender's numbers, the physical ratio of stiffness to mass is 1000 k/m [1/s^2].
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tatamu.simulation.blender.properties import COLLIDER, COLLISION, DEFAULTS, LENGTHS, RANGES, checked
from tatamu.simulation.blender.springs import Springs
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Scene

UNIT = float(np.sqrt(1e-3))
"""Blender's unit of time [s]."""
THICKNESS = 0.01
"""Thickness of the cloth in Blender [m].

The whole scene is scaled until the cloth has this thickness, because Blender's smallest contact distance is 1 mm."""
REACH = 2e-3
"""Smallest contact distance that the cloth and the table get in Blender [m].

With smaller distances, cloth that falls from 1 m would pass through the table. Because of these distances, Blender
keeps a gap between the table and the cloth. Therefore the table is lowered until the cloth lies at the right height.
"""
REST = 0.93
"""Ratio of the gap between table and cloth to the sum of their contact distances.

The ratio is at most 1 without load, and 8/9 under load (measured). The value lies between these two ratios."""
LAYERS = 1.125
"""Factor by which Blender's property `self_distance_min` is multiplied [-].

With this factor, layers of cloth have the right distance. In Blender, the distance between layers is 8/9 of twice
`self_distance_min` (measured)."""
TABLE_FRICTION, SELF_FRICTION = 100.0, 50.0
"""Friction numbers of Blender that correspond to a friction coefficient of 1 (measured).

The first number is for cloth on the table, and the second number is for layers of cloth."""
MOST_FRICTION = 80.0
"""Largest friction number that Blender accepts."""
COLLISION_LOOPS = 12
"""Number of times that Blender corrects contacts in each substep.

With fewer corrections, the friction of the table on a layer is not proportional to the load. For example, a sheet that
lies under another sheet should slide when the table is tilted by 39 degrees. With 4 corrections, it slides at 21
degrees (measured).
"""
LARGEST_STIFFNESS = 1e4
LONGEST_STEP = 1.0 / 300.0
"""Longest substep [s]. In this time, cloth with a speed of 1 m/s moves 3.3 mm."""
STABLE = 1.4
"""Largest allowed product h omega [-].

h is the length of a substep, and omega the largest angular frequency of bending. Bending is integrated explicitly,
which becomes unstable if h omega reaches 2."""
BENDING_DAMPING = 5e-4
"""Ratio of bending damping to bending stiffness, in Blender's unit of time.

Without damping, a hanging strip keeps oscillating by 1 mm."""
QUALITY = 5
"""Blender's default number of substeps in a frame whose length is one unit of Blender's time."""
DAMPING_RATIO = 0.1
"""Damping ratio of a single spring, as a fraction of critical damping."""


@dataclass
class Mapping:
    """The material, the table and the time of a scene, as properties of Blender."""

    settings: dict[str, Any] = field(default_factory=dict)
    """Properties of the cloth."""
    collision: dict[str, Any] = field(default_factory=dict)
    """Properties of the cloth's contacts."""
    collider: dict[str, Any] = field(default_factory=dict)
    """Properties of the table."""
    scale: float = 1.0
    """Ratio of lengths in Blender to lengths in metres."""
    clock: float | None = None
    """Duration of a frame of the rollout in Blender's unit of time.

    It comes from the raw property `time_scale` of the material. It is None if the material does not give this property.
    Then each frame has its real duration."""
    standoff: float = 0.0
    """Distance that Blender keeps between the table's plane and the cloth [m]."""
    warnings: list[str] = field(default_factory=list)

    def time_scale(self, duration: float, frame_rate: float) -> float:
        """Return a duration [s] in Blender's unit of time."""
        return duration / UNIT if self.clock is None else self.clock * duration * frame_rate

    def warn(self, text: str) -> None:
        """Add a warning about a property that Blender cannot represent."""
        self.warnings.append(f"blender: {text}")


def mapped(scene: Scene, longest: float) -> Mapping:
    """Return Blender's numbers for a scene.

    Blender simulates the scene in segments, each of which is one frame in Blender. `longest` is the duration of the
    longest segment [s].
    """
    if scene.material.blender is not None:
        return _raw(scene, longest)
    springs = Springs(scene.cloth)
    mapping = Mapping(scale=_scale(scene.material))
    mapping.settings["mass"] = 0.3
    _elasticity(mapping, scene, springs)
    _contact(mapping, scene.material)
    _drag(mapping, scene.material)
    _substeps(mapping, springs, longest)
    return mapping


def _scale(material: Material) -> float:
    return float(np.clip(THICKNESS / material.thickness, 0.25, 20.0))


def _elasticity(mapping: Mapping, scene: Scene, springs: Springs) -> None:
    material, count = scene.material, len(scene.cloth.vertices)
    vertex_mass = material.areal_density * springs.area / count
    per_newton = 1e-3 * mapping.settings["mass"] / vertex_mass
    spring = material.stretch_stiffness / springs.moduli.mean()
    tension = spring * per_newton * springs.mean_length * mapping.scale
    bending = material.bending_rigidity / springs.rigidities.mean() if len(springs.topology.hinges) else 0.0
    bending *= per_newton
    lighter = min(1.0, LARGEST_STIFFNESS / max(tension, bending, 1e-30))
    mass = mapping.settings["mass"] * lighter
    damping = 2.0 * DAMPING_RATIO * np.sqrt(spring * per_newton * lighter * mass)
    mapping.settings |= {
        "mass": mass,
        "bending_model": "ANGULAR",
        "bending_damping": BENDING_DAMPING * bending * lighter,
        **_each("{}_stiffness", tension * lighter),
        **_pair("compression_stiffness", tension * lighter * material.compression),
        **_each("{}_damping", min(50.0, float(damping))),
        **_pair("bending_stiffness", bending * lighter),
    }
    _isotropy(mapping, material, springs)


def _each(name: str, value: float) -> dict[str, float]:
    kinds = [name.format(kind) for kind in ("tension", "compression", "shear")]
    return {key: number for kind in kinds for key, number in _pair(kind, value).items()}


def _pair(name: str, value: float) -> dict[str, float]:
    return {name: float(value)} | ({f"{name}_max": float(value)} if name.endswith("stiffness") else {})


def _isotropy(mapping: Mapping, material: Material, springs: Springs) -> None:
    mapping.warn(f"springs have a Poisson ratio of 1/3, not {material.poisson_ratio:g}")
    spread = springs.moduli.max() / springs.moduli.min() - 1.0
    if spread > 0.15:
        mapping.warn(f"this mesh of springs is {100 * spread:.0f} % stiffer in one direction than in another")
    if not len(springs.topology.hinges):
        return
    stiffest, softest = springs.rigidities.max(), springs.rigidities.min()
    if softest < 1e-3 * stiffest:
        mapping.warn("this mesh bends in some directions only")
    elif stiffest / softest > 1.15:
        harder = 100 * (stiffest / softest - 1.0)
        mapping.warn(f"this mesh bends {harder:.0f} % harder in one direction than in another")


def _contact(mapping: Mapping, material: Material) -> None:
    gap = mapping.scale * material.thickness
    layers = float(np.clip(0.5 * LAYERS * gap, 1e-3, 0.1))
    reach = float(np.clip(max(REACH * mapping.scale, 0.5 * gap), 1e-3, 1.0))
    mapping.collision |= {
        "use_collision": True,
        "use_self_collision": True,
        "collision_quality": COLLISION_LOOPS,
        "distance_min": reach,
        "self_distance_min": layers,
        "self_friction": _friction(mapping, "friction_cloth", material.friction_cloth, SELF_FRICTION),
    }
    mapping.collider |= {
        "thickness_outer": reach,
        "cloth_friction": _friction(mapping, "friction_table", material.friction_table, TABLE_FRICTION),
        "damping": 0.0,
    }
    mapping.standoff = REST * 2.0 * reach / mapping.scale
    if layers > 0.501 * LAYERS * gap:
        apart = 2.0 * layers / LAYERS / mapping.scale
        mapping.warn(f"layers rest {1e3 * apart:.2g} mm apart, not {1e3 * material.thickness:.2g} mm")


def _friction(mapping: Mapping, name: str, coefficient: float, per_unit: float) -> float:
    most = MOST_FRICTION / per_unit
    if coefficient > most:
        mapping.warn(f"{name} is cut to {most:g}, the most that it knows, from {coefficient:g}")
    return min(MOST_FRICTION, per_unit * coefficient)


def _drag(mapping: Mapping, material: Material) -> None:
    rate = material.air_drag / material.areal_density
    mapping.settings["air_damping"] = 100.0 * mapping.settings["mass"] * rate * UNIT
    if mapping.settings["air_damping"] > 10.0:
        mapping.warn(f"air_drag is cut to {material.air_drag * 10.0 / mapping.settings['air_damping']:.3g} N s/m^3")
        mapping.settings["air_damping"] = 10.0


def _substeps(mapping: Mapping, springs: Springs, longest: float) -> None:
    """Set the number of substeps in a frame of Blender, so that contact and explicit bending are stable."""
    settings = mapping.settings
    frequency = springs.bending_frequency() * np.sqrt(settings["bending_stiffness"] / settings["mass"]) / UNIT
    step = min(LONGEST_STEP, STABLE / max(frequency, 1e-9))
    settings["quality"] = int(np.clip(np.ceil(longest / step - 1e-6), 1, 1000))
    if longest / settings["quality"] > 1.5 * step:
        mapping.warn("bending is too stiff for its explicit steps: expect jitter")


def _raw(scene: Scene, longest: float) -> Mapping:
    """Return the properties that a material's `blender` table gives in Blender's own numbers.

    The numbers are converted to the enlarged scene. If the table omits a property of the cloth, Blender's default is
    used. For the number of substeps (`quality`), the default depends on the duration of a frame in Blender's time. If
    the table omits a property of contacts, this property is computed from the material's fields in SI units.
    """
    raw = DEFAULTS | checked(scene.material.blender or {})
    growing = [name for name in raw if _grows(name, raw.get("bending_model") == "LINEAR")]
    fitting = (RANGES[name][1] / max(float(raw[name]), 1e-9) for name in growing)
    mapping = Mapping(scale=max(1.0, min(_scale(scene.material), *fitting)))
    _contact(mapping, scene.material)
    mapping.clock = float(raw.pop("time_scale")) if "time_scale" in raw else None
    for name, value in raw.items():
        part = mapping.collision if name in COLLISION else mapping.collider if name in COLLIDER else mapping.settings
        part[name] = mapping.scale * float(value) if name in growing else value
    mapping.settings.setdefault("quality", _substeps_by_default(mapping.time_scale(longest, scene.frame_rate)))
    mapping.standoff = REST * (mapping.collision["distance_min"] + mapping.collider["thickness_outer"]) / mapping.scale
    return mapping


def _grows(name: str, linear: bool) -> bool:
    """Return whether a number must be scaled with the scene, so that the enlarged scene moves in the same way.

    Lengths and speeds are scaled. Stiffnesses of springs are scaled, because they are forces per relative stretch. The
    numbers of dampers are not scaled, because they are forces per speed. The stiffness of hinges is not scaled, because
    the force of a hinge is already proportional to the length of its edge.
    """
    kind, _, what = name.partition("_")
    spring = kind in ("tension", "compression", "shear") or (linear and kind == "bending")
    return name in LENGTHS or (spring and what.startswith("stiffness"))


def _substeps_by_default(frame: float) -> int:
    """Return Blender's default number of substeps, rounded up, for a frame of `frame` units of Blender's time."""
    return int(np.clip(np.ceil(QUALITY * frame - 1e-6), 1, 1000))
