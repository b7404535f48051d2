"""Conversion of a material from SI units to Blender's own numbers, measured in docs/theory/blender.md.

Blender multiplies gravity by 0.001 and counts time in frames, so its unit of time is sqrt(0.001) s = 31.6 ms. If k and
m are a stiffness and a mass in its numbers, the physical ratio of stiffness to mass is 1000 k/m [1/s^2].
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tatamu.simulation.blender.properties import PROPERTIES, STIFFNESS, checked
from tatamu.simulation.blender.springs import Springs
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Scene

UNIT = float(np.sqrt(1e-3))
"""Blender's unit of time [s]."""
THICKNESS = 0.01
"""Thickness to which cloth is scaled in Blender [m], because Blender's minimum contact distance is 1 mm."""
REACH = 2e-3
"""Minimum contact distance of cloth and table in Blender [m]. With less, cloth that falls from 1 m would pass through
the table, which is lowered by the gap that the distances leave."""
REST = 0.93
"""Gap between table and cloth, divided by the sum of their contact distances [-]: between 1, its maximum without load,
and 8/9, its value under load (measured)."""
LAYERS = 1.125
"""Factor on `self_distance_min` [-], because the distance of layers is 8/9 of twice that property (measured)."""
TABLE_FRICTION, SELF_FRICTION = 100.0, 50.0
"""Blender's numbers for a friction coefficient of 1, on the table and between layers (measured)."""
MAX_FRICTION = PROPERTIES["self_friction"].high
"""Maximum friction number that Blender accepts."""
MAX_STEP = 1.0 / 300.0
"""Maximum substep [s], in which cloth with a speed of 1 m/s moves 3.3 mm."""


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
    """Duration of a frame of the rollout [Blender's time] from the raw property `time_scale`; None for the real one."""
    standoff: float = 0.0
    """Distance that Blender keeps between the table's plane and the cloth [m]."""
    warnings: list[str] = field(default_factory=list)

    def time_scale(self, duration: float, frame_rate: float) -> float:
        """Return a duration [s] in Blender's unit of time."""
        return duration / UNIT if self.clock is None else self.clock * duration * frame_rate

    def warn(self, text: str) -> None:
        self.warnings.append(f"blender: {text}")


def mapped(scene: Scene, longest: float) -> Mapping:
    """Return Blender's numbers for a scene whose longest segment, one frame in Blender, lasts `longest` [s]."""
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
    tension = spring * per_newton * float(springs.lengths.mean()) * mapping.scale
    bending = material.bending_rigidity / springs.rigidities.mean() if len(springs.topology.hinges) else 0.0
    bending *= per_newton
    lighter = min(1.0, STIFFNESS[1] / max(tension, bending, 1e-30))
    mass = mapping.settings["mass"] * lighter
    damping = 2.0 * 0.1 * np.sqrt(spring * per_newton * lighter * mass)  # a tenth of critical, for a single spring
    spring_stiffness = tension * lighter
    stiffness = {
        "tension": spring_stiffness,
        "compression": spring_stiffness * material.compression,
        "shear": spring_stiffness,
        "bending": bending * lighter,
    }
    mapping.settings |= {
        "mass": mass,
        "bending_model": "ANGULAR",
        "bending_damping": 5e-4 * bending * lighter,  # without it, a hanging strip oscillates by 1 mm
        **{f"{kind}_stiffness{end}": float(value) for kind, value in stiffness.items() for end in ("", "_max")},
        **{f"{kind}_damping": min(50.0, float(damping)) for kind in ("tension", "compression", "shear")},
    }
    _isotropy(mapping, material, springs)


def _isotropy(mapping: Mapping, material: Material, springs: Springs) -> None:
    mapping.warn(f"springs have a Poisson ratio of 1/3 instead of {material.poisson_ratio:g}")
    spread = springs.moduli.max() / springs.moduli.min() - 1.0
    if spread > 0.15:
        mapping.warn(f"this mesh of springs is {100 * spread:.0f} % stiffer in one direction than in another")
    if not len(springs.topology.hinges):
        return
    stiffest, softest = springs.rigidities.max(), springs.rigidities.min()
    if softest < 1e-3 * stiffest:
        mapping.warn("this mesh resists bending in some directions only")
    elif stiffest / softest > 1.15:
        harder = 100 * (stiffest / softest - 1.0)
        mapping.warn(f"this mesh resists bending {harder:.0f} % more in one direction than in another")


def _contact(mapping: Mapping, material: Material) -> None:
    gap = mapping.scale * material.thickness
    layers = float(np.clip(0.5 * LAYERS * gap, 1e-3, 0.1))
    reach = float(np.clip(max(REACH * mapping.scale, 0.5 * gap), 1e-3, 1.0))
    mapping.collision |= {
        "use_collision": True,
        "use_self_collision": True,
        # Corrections of contacts in each substep. With fewer, friction is not proportional to the load: with 4, a sheet
        # under another one slides on a table that is tilted by 21 degrees instead of 39 (measured).
        "collision_quality": 12,
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
        mapping.warn(f"layers rest {1e3 * apart:.2g} mm apart instead of {1e3 * material.thickness:.2g} mm")


def _friction(mapping: Mapping, name: str, coefficient: float, per_unit: float) -> float:
    most = MAX_FRICTION / per_unit
    if coefficient > most:
        mapping.warn(f"{name} is reduced from {coefficient:g} to {most:g}, the maximum in Blender")
    return min(MAX_FRICTION, per_unit * coefficient)


def _drag(mapping: Mapping, material: Material) -> None:
    rate = material.air_drag / material.areal_density
    mapping.settings["air_damping"] = 100.0 * mapping.settings["mass"] * rate * UNIT
    if mapping.settings["air_damping"] > 10.0:
        mapping.warn(
            f"air_drag is reduced to {material.air_drag * 10.0 / mapping.settings['air_damping']:.3g} N s/m^3, the "
            "maximum in Blender"
        )
        mapping.settings["air_damping"] = 10.0


def _substeps(mapping: Mapping, springs: Springs, longest: float) -> None:
    """Set the substeps in a frame of Blender, so that contact and explicit bending are stable."""
    settings = mapping.settings
    frequency = springs.bending_frequency() * np.sqrt(settings["bending_stiffness"] / settings["mass"]) / UNIT
    step = min(MAX_STEP, 1.4 / max(frequency, 1e-9))  # bending is unstable if step times frequency is 2
    settings["quality"] = int(np.clip(np.ceil(longest / step - 1e-6), 1, 1000))
    if longest / settings["quality"] > 1.5 * step:
        mapping.warn("the cloth may jitter, because its bending is too stiff for the time steps; give a larger spacing")


def _raw(scene: Scene, longest: float) -> Mapping:
    """Return the properties in a material's `blender` table, converted to the enlarged scene.

    Properties of contact that the table omits follow from the material's fields in SI units; others are Blender's
    defaults, where the number of substeps (`quality`) depends on the duration of a frame.
    """
    usual = {name: known.default for name, known in PROPERTIES.items() if known.default is not None}
    raw = usual | checked(scene.material.blender or {})
    growing = [name for name in raw if _grows(name, raw.get("bending_model") == "LINEAR")]
    fitting = (PROPERTIES[name].high / max(float(raw[name]), 1e-9) for name in growing)
    mapping = Mapping(scale=max(1.0, min(_scale(scene.material), *fitting)))
    _contact(mapping, scene.material)
    mapping.clock = float(raw.pop("time_scale")) if "time_scale" in raw else None
    for name, value in raw.items():
        part: dict[str, Any] = getattr(mapping, PROPERTIES[name].part)
        part[name] = mapping.scale * float(value) if name in growing else value
    frame = mapping.time_scale(longest, scene.frame_rate)  # Blender makes 5 substeps in a unit of its time, rounded up
    mapping.settings.setdefault("quality", int(np.clip(np.ceil(5 * frame - 1e-6), 1, 1000)))
    mapping.standoff = REST * (mapping.collision["distance_min"] + mapping.collider["thickness_outer"]) / mapping.scale
    return mapping


def _grows(name: str, linear: bool) -> bool:
    """Return whether a number must be scaled with the scene, so that the enlarged scene moves in the same way.

    Dampers are forces per speed, and the force of a hinge is already proportional to the length of its edge, so only
    lengths, speeds and springs (forces per relative stretch) are scaled.
    """
    kind, _, what = name.partition("_")
    spring = kind in ("tension", "compression", "shear") or (linear and kind == "bending")
    return PROPERTIES[name].length or (spring and what.startswith("stiffness"))
