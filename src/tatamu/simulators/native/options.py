"""Settings that a study may vary: one frozen record, handed to `simulate`.

All numbers in the documentation were made with the defaults. The calibrated material is part of the scene, not of the
options. Each part is a NamedTuple, which compiled loops accept; other values need no new compilation (see
docs/theory/native-symbols.md for symbols and names).

    simulate(scene, options=Options(contact=ContactOptions(clearing_speed=0.25)))
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

import numpy as np

from tatamu.errors import InputError


class StepOptions(NamedTuple):
    """Time stepping."""

    outer_step: float = 1e-3
    """Longest outer step H [s]: contact and friction are resolved at least this often."""
    membrane_phase: float = 1.25
    """Largest h omega of the membrane's steps [-].

    2 is the limit of stability; the difference allows for large strains.
    """
    bending_phase: float = 1.0
    """Largest h omega of the bending steps [-]; as above, for large angles."""
    sticking_phase: float = 1.5
    """Largest h omega of the bending steps while all friction of bending sticks [-]; it may be larger, because friction
    that slips takes energy."""
    membrane_damping: float = 5e-5
    """Time constant tau_d of the membrane's Kelvin-Voigt damping [s]."""
    damping_part: float = 0.3
    """Largest tau_d, as part of the membrane's step [-]; more would be unstable."""


class ElasticOptions(NamedTuple):
    """Elastic forces."""

    angle_sum_part: float = 0.45
    """Weight a of operator C in the curvature Q = a C + (1 - a) R^-1 [-]: here irregular and turned meshes are too soft
    as often as too stiff (benchmarks/statics.py)."""
    crowding_strain: float = 0.2
    """Green strain b: compressed by it, cloth that wrinkles is as stiff again as in tension [-]; its length is 0.77."""


class ContactOptions(NamedTuple):
    """Contact of cloth with itself and with the table. Parts of a thickness are parts of the cloth's thickness t."""

    # Candidates.
    margin_thicknesses: float = 3.0
    """Margin of the broad phase beyond a thickness [t], unless the next two options change it."""
    margin_edges: float = 0.75
    """A wider margin, as part of the longest edge [-]: coarse cloth moves farther between two searches."""
    margin_limit: float = 0.01
    """Largest margin because of the longest edge [m]."""
    margin_wear: float = 0.8
    """Candidates are searched again once this part of their margin may be used up [-]."""
    crease_cosine: float = 0.5
    """Cosine of normals below which cloth counts as folded [-], so that vertices avoid neighbouring triangles."""
    ridge_cosine: float = 0.94
    """Edges whose triangles' normals have a cosine below this are guarded like borders [-]: creased by 20 degrees."""
    level_cosine: float = 0.7
    """Cosine above which the plane of a triangle determines its side of a vertex [-]."""
    same_direction_cosine: float = 0.8
    """Two triangles that a vertex is kept from in directions with a larger cosine count as one sheet [-]."""
    touching: float = 1.1
    """A triangle closer than this is in contact, and stays a candidate though two others are nearer [t]."""
    pressed: float = 0.6
    """Layers closer than this are pressed: their edges are guarded as well [t]."""
    pressed_searches: int = 4
    """Searches for which the edges at a pressed vertex stay guarded."""
    pairs_per_edge: int = 24
    """Largest number of edge pairs per edge of the mesh, for which memory is reserved."""

    # How far positions are corrected.
    barycentric_tolerance: float = 0.02
    """Largest distance outside a triangle, in barycentric coordinates, that counts as inside [-]."""
    edge_gap: float = 0.75
    """Edges are kept this far from edges [t]; vertices are kept a whole thickness from triangles."""
    clearing_speed: float = 0.5
    """Speed at which layers that are too close are separated [m/s], so that tangled cloth does not explode."""
    recovery_speed: float = 0.1
    """The part of that speed which they keep as velocity [m/s]; the rest is position only (split impulse)."""
    restored: tuple[float, ...] | np.ndarray = (1.0, 0.5, 0.5, 0.3, 0.3, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2)
    """Part of the gap that each Gauss-Seidel sweep restores [-]; its length is the largest number of sweeps.

    The first sweep restores the whole gap. Later ones, made only while a pair is still closer, restore less, because
    layers that a hand crushes have no room for the whole gap. Compiled loops get an array, so that any length has the
    same type.
    """
    noticeable: float = 0.02
    """Corrections beyond this make the next sweep test the moved vertices again [t]."""

    # How often, where layers are crushed.
    restless: float = 0.25
    """Contact that moves a vertex by more than this is resolved twice as often from then on, at most after every
    substep [t]: layers that hands crush would otherwise swing by thicknesses between two corrections."""
    calm: float = 0.08
    """Contact that moves no vertex by more than this is resolved half as often [t]."""
    sweeps_of_many: int = 5
    """Sweeps at most in each of several rounds per outer step: the next round is soon."""
    hard: float = 0.08
    """Corrections beyond this make vertices restless [t].

    Only restless vertices can pass through cloth, and are tested for impact zones.
    """
    restless_steps: int = 3
    """Outer steps for which they then are."""
    zone_passes: int = 30
    """Largest number of passes in which impact zones may grow; the rest is left to the next step."""


class UntangleOptions(NamedTuple):
    """Options for untangling layers that passed through each other while a hand was closed."""

    step: float = 0.3
    """Distance by which one pass moves an edge against a triangle [t]."""
    most_passes: int = 60
    """Passes, at most."""
    flattest: float = 1e-3
    """An edge less steep on a triangle than this sine counts as this steep [-]."""
    blunt: float = 0.1
    """Length of the sum of directions below which a pass moves less, because the direction is uncertain [-]."""
    shortest: float = 0.7
    """Least part of their rest length that edges keep meanwhile [-]; shorter edges would be thrown by the membrane."""
    longest: float = 1.1
    """Edges keep at most this part of their rest length [-]."""
    slimmest: float = 0.1
    """Triangles stay higher than this part of the shortest edge, or than they were [-]: bending forces go with the
    inverse."""
    length_sweeps: int = 4
    """Sweeps per pass that give edges back such lengths."""
    again_after: float = 0.1
    """Layers that were not taken apart are tried again after this time [s]."""


class RestOptions(NamedTuple):
    """When cloth that no hand holds, or will hold, counts as resting; it is not moved any more from then on."""

    every: float = 0.1
    """Time between two looks [s]."""
    still: float = 1e-4
    """Mean displacement between two looks below which the cloth rests [m]; 0, and it never does."""


class LimitOptions(NamedTuple):
    """Limits at which a rollout is refused or ended."""

    largest_stretch: float = 1.5
    """Largest stretch of an edge [-]; beyond it the rollout ends, because the membrane model is not valid."""
    farthest: float = 1e4
    """Cloth farther than this from the origin ends the rollout [m]."""
    thickest: float = 0.9
    """Thickness is refused beyond this part of the shortest edge [-]."""
    most_work: float = 1e12
    """Steps of a vertex that a rollout may need: about two hours."""
    fastest_hand: float = 10.0
    """A target that a hand would have to reach at a higher speed is refused [m/s]: arms move at 2, a throw at 10."""
    most_bytes_in_double: float = 64e6
    """Frames that take more bytes are kept in single precision, which rounds a meter by 0.06 micrometers."""


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
    """Everything that a study may vary of the embedded simulator.

    Raises:
        InputError: A number is negative or not finite, one that must be positive is zero, or the first sweep does not
            restore everything.
    """

    step: StepOptions = field(default_factory=StepOptions)
    elastic: ElasticOptions = field(default_factory=ElasticOptions)
    contact: ContactOptions = field(default_factory=ContactOptions)
    untangle: UntangleOptions = field(default_factory=UntangleOptions)
    rest: RestOptions = field(default_factory=RestOptions)
    limits: LimitOptions = field(default_factory=LimitOptions)

    def __post_init__(self) -> None:
        """Check, and make every number of the type that its default has: kernels are compiled for types."""
        for part in ("step", "elastic", "contact", "untangle", "rest", "limits"):
            given = getattr(self, part)
            defaults = type(given)._field_defaults
            values = {
                name: _checked(f"{part}.{name}", value, defaults[name]) for name, value in given._asdict().items()
            }
            object.__setattr__(self, part, type(given)(**values))


def _checked(name: str, value: Any, default: Any) -> Any:
    if isinstance(default, tuple):
        parts = tuple(float(part) for part in value)
        if not parts or parts[0] != 1.0 or not all(0.0 < part <= 1.0 for part in parts):
            raise InputError(f"{name}: must begin with 1 and go on with parts above 0 and up to 1, given {value}")
        return parts
    number = type(default)(value)
    if not 0.0 <= number < inf or (number == 0.0 and name in _POSITIVE):
        least = "positive" if name in _POSITIVE else "at least 0"
        raise InputError(f"{name}: must be {least} and finite, given {value}")
    return number
