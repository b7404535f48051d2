"""Settings of the simulator that a study can vary: `simulate(scene, options=Options(rest=RestOptions(every=0.2)))`.

Each group is a NamedTuple, which compiled loops accept, so other values need no new compilation. Symbols are listed in
docs/theory/native-symbols.md. The calibrated material is a part of the scene and not of the options.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

import numpy as np

from tatamu.base.errors import InputError


class StepOptions(NamedTuple):
    """Settings of the time steps."""

    outer_step: float = 1e-3
    """Maximum length H of an outer step [s], in which contact is resolved at least once, for layers up to 1 mm thick.
    Layers of twice the thickness may approach twice as far in a step (`model.room`)."""
    membrane_phase: float = 1.25
    """Maximum product h omega for steps h of the membrane, whose largest angular frequency at rest is omega [-]. Steps
    are stable below 2; the rest is a reserve for large strains."""
    bending_phase: float = 1.0
    """Maximum product h omega for steps of bending [-], with a reserve for large angles."""
    sticking_phase: float = 1.5
    """Maximum product h omega while friction of bending sticks [-]; larger, because its slip removes energy."""
    membrane_damping: float = 5e-5
    """Time constant tau_d of the membrane's Kelvin-Voigt damping [s]."""
    damping_part: float = 0.3
    """Maximum time constant tau_d, as a fraction of the membrane's time step [-]; a larger one would be unstable."""


class ElasticOptions(NamedTuple):
    """Settings of the elastic forces."""

    angle_sum_part: float = 0.45
    """Weight a in the curvature Q = a C + (1 - a) R^-1 (`elastic.curvature`) [-]. With this value, about half of the
    irregular and rotated meshes are too soft, and the others are too stiff (tests/statics.py)."""
    crowding_strain: float = 0.2
    """Maximum compressive Green strain b at which cloth that wrinkles is soft [-]; at 0.2, edges shrink to 0.77."""


class ContactOptions(NamedTuple):
    """Settings of contact between layers, and between cloth and table."""

    # Candidates: pairs of mesh elements that may touch.
    margin_thicknesses: float = 3.0
    """Margin beyond one thickness within which candidates are found [thicknesses]; `margin_edges` may increase it."""
    margin_edges: float = 0.75
    """Minimum margin up to `margin_limit` [longest edges], as large triangles move farther between two searches."""
    margin_limit: float = 0.01
    """Maximum margin that follows from `margin_edges` [m], for layers up to 1 mm thick (`model.room`)."""
    margin_wear: float = 0.8
    """Fraction of the margin by which two vertices may approach each other before the next search [-]."""
    crease_cosine: float = 0.5
    """Cosine between normals below which cloth is folded, so that vertices also avoid neighbouring triangles [-]."""
    ridge_cosine: float = 0.94
    """Cosine between two triangles below which their edge is guarded, kept away from other edges [-]: 20 degrees."""
    level_cosine: float = 0.7
    """Cosine between a vertex and a triangle above which the triangle's plane determines the vertex's side [-]."""
    same_direction_cosine: float = 0.8
    """Cosine above which two triangles that keep a vertex away count as one sheet [-]."""
    touching: float = 1.1
    """Distance up to which a triangle stays a candidate even if two others are nearer [thicknesses]."""
    pressed: float = 0.6
    """Distance of layers below which their edges are kept apart too, as pressed layers [thicknesses]."""
    pressed_searches: int = 4
    """Number of searches for which a vertex counts as pressed, after its layers were pressed together."""
    pairs_per_edge: int = 24
    """Maximum number of edge pairs per edge of the mesh, for which memory is reserved."""

    # Size of the corrections of positions.
    barycentric_tolerance: float = 0.02
    """Maximum distance outside a triangle that counts as inside, in barycentric coordinates [-]."""
    edge_gap: float = 0.75
    """Distance that contact keeps between two edges [thicknesses]; between a vertex and a triangle, it is one."""
    clearing_speed: float = 0.5
    """Speed at which layers that are too close are separated [m/s], limited so that tangled cloth does not explode."""
    recovery_speed: float = 0.1
    """Part of this speed that becomes velocity [m/s]; the rest only changes positions (split impulse)."""
    restored: tuple[float, ...] | np.ndarray = (1.0, 0.5, 0.5, 0.3, 0.3, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2)
    """Fraction of the full distance between layers that each Gauss-Seidel sweep restores [-].

    A sweep is made only if a pair is closer than the distance that it restores. Later sweeps restore less, because
    layers that a hand crushes have no room. Compiled loops receive an array."""
    noticeable: float = 0.02
    """Correction above which the next sweep tests the moved vertices again [thicknesses]."""

    # Frequency of contact, and vertices that are moved far by contact ("restless" vertices).
    restless: float = 0.25
    """Movement of a vertex by contact above which the next outer step resolves contact twice as often [thicknesses].
    Otherwise layers that hands crush would oscillate by several thicknesses between two corrections."""
    calm: float = 0.08
    """Movement of any vertex below which the next outer step resolves contact half as often [thicknesses]."""
    held: float = 0.25
    """Fraction of a movement that counts if contact only holds a vertex in its place [-], as in layers that a hand
    presses on the table, where resolving contact more often changes nothing."""
    sweeps_of_many: int = 5
    """Maximum number of sweeps in a round, if contact is resolved several times per outer step."""
    hard: float = 0.08
    """Correction above which a vertex is restless [thicknesses]. Only such vertices are tested for passing."""
    restless_steps: int = 3
    """Number of outer steps for which a vertex stays restless."""
    zone_passes: int = 30
    """Maximum number of passes in which impact zones grow in a round; what still passes is left to the next step."""


class UntangleOptions(NamedTuple):
    """Settings for separating layers that passed through each other while a hand was closed."""

    step: float = 0.3
    """Distance by which one pass moves an edge relative to a triangle [thicknesses]."""
    most_passes: int = 60
    """Maximum number of passes."""
    flattest: float = 1e-3
    """Minimum sine of the angle between an edge and a triangle [-]; smaller ones are replaced by it."""
    blunt: float = 0.1
    """Length of the direction G (`contact.untangle`) below which it is uncertain and an edge moves less [-]."""
    shortest: float = 0.7
    """Minimum length of edges during separation [rest lengths]; the membrane would throw shorter ones apart."""
    longest: float = 1.1
    """Maximum length of edges during separation [rest lengths]."""
    slimmest: float = 0.1
    """Minimum height of triangles after separation [shortest edges]; bending forces grow with its inverse."""
    length_sweeps: int = 4
    """Sweeps in each pass that bring the lengths of edges back between `shortest` and `longest`."""
    again_after: float = 0.1
    """Time to the next attempt if layers are still crossed, or were separated [s]."""


class RestOptions(NamedTuple):
    """Settings of the test whether cloth that no hand holds or will hold is at rest, after which it does not move."""

    every: float = 0.1
    """Time between two tests [s]."""
    still: float = 1e-4
    """Mean displacement between two tests below which cloth is at rest [m]; with 0, it never is."""


class LimitOptions(NamedTuple):
    """Limits at which a rollout is refused or stopped."""

    largest_stretch: float = 1.5
    """Maximum stretch of an edge [-], above which the membrane model is not valid and a rollout stops."""
    farthest: float = 1e4
    """Maximum distance of the cloth from the origin [m], beyond which a rollout stops."""
    thickest: float = 0.9
    """Maximum thickness [shortest edges]; scenes with thicker cloth are refused."""
    most_work: float = 1e12
    """Maximum product of time steps and vertices, about two hours; scenes with more are refused."""
    fastest_hand: float = 10.0
    """Maximum speed of a hand's target [m/s]; arms move at 2 m/s, and a throw reaches 10 m/s."""
    most_bytes_in_double: float = 64e6
    """Size of all frames above which they are kept in single precision, to 0.06 micrometres in a metre [bytes]."""


_POSITIVE = {
    "step.outer_step",
    "step.membrane_phase",
    "step.bending_phase",
    "step.sticking_phase",
    "contact.edge_gap",
    "contact.sweeps_of_many",
    "rest.every",
}


@dataclass(frozen=True)
class Options:
    """All settings of this simulator that a study can vary; InputError if one is out of range."""

    step: StepOptions = field(default_factory=StepOptions)
    elastic: ElasticOptions = field(default_factory=ElasticOptions)
    contact: ContactOptions = field(default_factory=ContactOptions)
    untangle: UntangleOptions = field(default_factory=UntangleOptions)
    rest: RestOptions = field(default_factory=RestOptions)
    limits: LimitOptions = field(default_factory=LimitOptions)

    def __post_init__(self) -> None:
        """Check all numbers, and convert each to the type of its default, because kernels are compiled for types."""
        for part, given in vars(self).copy().items():
            pairs = zip(given._fields, given, given._field_defaults.values(), strict=True)
            checked = [_checked(f"{part}.{name}", value, default) for name, value, default in pairs]
            object.__setattr__(self, part, type(given)(*checked))


def _checked(name: str, value: Any, default: Any) -> Any:
    if isinstance(default, tuple):
        parts = tuple(float(part) for part in value)
        if not parts or parts[0] != 1.0 or not all(0.0 < part <= 1.0 for part in parts):
            raise InputError(f"{name}: must be 1, followed by numbers above 0 and at most 1, given {value}")
        return parts
    number = type(default)(value)
    if not 0.0 <= number < inf or (number == 0.0 and name in _POSITIVE):
        least = "positive" if name in _POSITIVE else "at least 0"
        raise InputError(f"{name}: must be {least} and finite, given {value}")
    return number
