"""The mesh on which folds are learned: larger triangles than the garment's own, which resolve every crease.

Large triangles lock: where cloth curves in two directions, they must stretch instead of bend, and the cloth seems too
stiff. The effect depends on Y h^2 / B, with the stretch stiffness Y, the spacing h and the bending rigidity B. On a
mesh whose spacing is k times the garment's own, scenes therefore have the stretch stiffness Y / k^2.

The ratios are the largest for which a fold succeeds on this mesh whenever it does on a mesh of half the spacing, in at
least 95 of 100 scenarios (`make meshes`, docs/notes/learning.md).
"""

from __future__ import annotations

from dataclasses import replace

from tatamu.base.errors import InputError
from tatamu.folding.fold import ideal_folds
from tatamu.folding.plan import Plan
from tatamu.garments import Garment, make_garment
from tatamu.simulation.material import ORTHOTROPIC_MEMBRANE, Material


def learning_mesh(garment: Garment, plan: Plan, hands: int | None) -> tuple[Garment, float]:
    """Return a garment on the mesh on which it is folded, and the divisor k^2 of its stretch stiffness.

    A garment keeps its mesh if its spacing was given, if `make_garment` did not make it, and if it is small.
    """
    source = garment.source
    if source is None or garment.spacing_given:
        return garment, 1.0
    ratio = 1.5 if len(plan.steps) > 1 else 2.0 if garment.layers == 1 else 1.7  # loops of earlier steps spring open
    try:
        made = make_garment(source.name, source.size, garment.material, ratio * garment.spacing, source.scale)
        ideal_folds(made, plan, hands)
    except InputError:
        return garment, 1.0
    if not 250 <= len(made.vertices) < len(garment.vertices):
        return garment, 1.0
    return replace(made, source=source), ratio**2


def softened(material: Material, divisor: float) -> Material:
    """Return a material whose stretch and shear stiffnesses are divided."""
    if divisor == 1.0:
        return material
    known = {name: getattr(material, name) for name in ("stretch_stiffness", *ORTHOTROPIC_MEMBRANE)}
    return material.model_copy(update={name: value / divisor for name, value in known.items() if value is not None})
