"""Settings of the simulator that a study can vary, as one immutable record for `simulate`.

All numbers in the documentation were made with the defaults. The calibrated material is a part of the scene and not of
the options. Each group of options is a NamedTuple, which compiled loops accept. Other values need no new compilation.
Symbols and names are listed in docs/theory/native-symbols.md. An example is:

    simulate(scene, options=Options(contact=ContactOptions(clearing_speed=0.25)))
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
    """Largest length H of an outer step, the longest of the time steps [s].

    Contact is resolved at least once in each outer step."""
    membrane_phase: float = 1.25
    """Largest product h omega for the steps of the membrane [-].

    h is the time step, and omega the largest angular frequency of the membrane at rest. The limit of stability is 2.
    This value is smaller, as a reserve for large strains.
    """
    bending_phase: float = 1.0
    """Largest product h omega for the steps of bending [-].

    h is the time step, and omega the largest angular frequency of bending at rest. The limit of stability is 2. This
    value is smaller, as a reserve for large angles."""
    sticking_phase: float = 1.5
    """Largest product h omega for the steps of bending while its friction sticks [-].

    h is the time step, and omega the largest angular frequency. The product can be larger than `bending_phase`, because
    friction that slips removes energy."""
    membrane_damping: float = 5e-5
    """Time constant tau_d of the membrane's Kelvin-Voigt damping [s]."""
    damping_part: float = 0.3
    """Largest time constant tau_d of damping, as a fraction of the membrane's time step [-].

    A larger time constant would be unstable."""


class ElasticOptions(NamedTuple):
    """Settings of the elastic forces."""

    angle_sum_part: float = 0.45
    """Weight a in the formula Q = a C + (1 - a) R^-1 of the curvature [-].

    C and R^-1 are two matrices from the dihedral angles of a triangle to its curvatures (`elastic.curvature`). With
    this value, about half of the irregular and rotated meshes are too soft, and the others are too stiff
    (tests/statics.py)."""
    crowding_strain: float = 0.2
    """Largest compressive Green strain b at which cloth that wrinkles is soft [-].

    Beyond it, cloth has its full stiffness. At b = 0.2, an edge has 0.77 of its rest length."""


class ContactOptions(NamedTuple):
    """Settings of contact between layers of cloth, and between cloth and table.

    Many of the lengths are given in thicknesses of the cloth.
    """

    # Candidates: pairs of mesh elements that may touch.
    margin_thicknesses: float = 3.0
    """Margin of the search for contact [thicknesses of the cloth].

    Candidates are searched within one thickness plus this margin. The options `margin_edges` and `margin_limit` can
    increase the margin."""
    margin_edges: float = 0.75
    """Least margin of the search for contact, as a fraction of the longest edge of the mesh [-].

    It is limited by `margin_limit`. Coarse cloth needs a larger margin, because it moves farther between two
    searches."""
    margin_limit: float = 0.01
    """Upper limit for the margin of the search for contact, if the margin follows from `margin_edges` [m]."""
    margin_wear: float = 0.8
    """Fraction of the search margin that motion may use up [-].

    The search for candidates is repeated when two vertices may have approached each other by this fraction of the
    margin."""
    crease_cosine: float = 0.5
    """Smallest cosine between the normals of cloth that does not count as folded [-].

    If the cosine between the normals of two parts of the cloth is smaller, the cloth counts as folded there. In folded
    cloth, vertices also avoid neighbouring triangles."""
    ridge_cosine: float = 0.94
    """Smallest cosine between the normals of two triangles whose shared edge is not guarded [-].

    If the cosine is smaller, the edge is guarded, which means that it is kept away from other edges. Edges at a border
    are always guarded. The default corresponds to a crease of 20 degrees."""
    level_cosine: float = 0.7
    """Largest cosine between the normals of a vertex and a triangle that do not count as nearly parallel [-].

    If the cosine is larger, the plane of the triangle determines on which side of the triangle the vertex lies."""
    same_direction_cosine: float = 0.8
    """Largest cosine between two directions that count as different [-].

    Two triangles that keep a vertex away in the same direction count as one sheet."""
    touching: float = 1.1
    """Largest distance of a vertex and a triangle that count as touching [thicknesses of the cloth].

    A triangle that touches a vertex stays a candidate even if two other triangles are nearer."""
    pressed: float = 0.6
    """Smallest distance of layers that do not count as pressed [thicknesses of the cloth].

    If layers are closer, not only their vertices but also their edges are kept away from each other."""
    pressed_searches: int = 4
    """Number of searches for candidates for which a vertex counts as pressed.

    The number is counted from the last time at which the layers at the vertex were pressed together."""
    pairs_per_edge: int = 24
    """Largest number of edge pairs per edge of the mesh. Memory is reserved for this number."""

    # Size of the corrections of positions.
    barycentric_tolerance: float = 0.02
    """Largest distance outside a triangle that still counts as inside, in barycentric coordinates [-]."""
    edge_gap: float = 0.75
    """Distance that contact keeps between two edges [thicknesses of the cloth].

    Between a vertex and a triangle, contact keeps a distance of one thickness."""
    clearing_speed: float = 0.5
    """Speed at which layers that are too close are separated [m/s].

    It is limited so that tangled cloth does not explode."""
    recovery_speed: float = 0.1
    """Part of the separation speed that layers keep as velocity [m/s].

    The rest of the separation only changes positions (split impulse)."""
    restored: tuple[float, ...] | np.ndarray = (1.0, 0.5, 0.5, 0.3, 0.3, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2)
    """Distance that each Gauss-Seidel sweep of contact restores between layers, as a fraction of the full distance [-].

    The number of entries is the largest number of sweeps. The first sweep restores the full distance. A later sweep is
    made only if a pair is closer than the distance that this sweep restores. Later sweeps restore less, because layers
    that a hand crushes have no room for the full distance. Compiled loops receive an array, which has the same type for
    any number of entries.
    """
    noticeable: float = 0.02
    """Largest correction by contact that is negligible [thicknesses of the cloth].

    After a larger correction, the next sweep tests the moved vertices again."""

    # Frequency of contact, and vertices that are moved far by contact ("restless" vertices).
    restless: float = 0.25
    """Upper limit for the movement of any vertex by contact [thicknesses of the cloth].

    If a movement exceeds the limit, contact is resolved twice as often in the next outer step as in the present outer
    step. Contact is resolved at most once after every substep. If contact were not resolved more often, layers that
    hands crush would oscillate by several thicknesses between two corrections."""
    calm: float = 0.08
    """Lower limit for the largest movement of any vertex by contact [thicknesses of the cloth].

    If the largest movement is below the limit, contact is resolved half as often in the next outer step as in the
    present outer step."""
    held: float = 0.25
    """Fraction of a movement by contact that counts if contact only holds the vertex in its place [-].

    Layers that a hand presses on the table have no room, so contact moves them back to the same positions each time.
    Resolving contact more often does not change that."""
    sweeps_of_many: int = 5
    """Largest number of sweeps each time that contact is resolved, if it is resolved several times per outer step."""
    hard: float = 0.08
    """Largest correction by contact that counts as gentle [thicknesses of the cloth].

    After a larger correction, a vertex counts as restless. Only restless vertices are tested for passing through cloth.
    """
    restless_steps: int = 3
    """Number of outer steps for which a vertex stays restless."""
    zone_passes: int = 30
    """Largest number of passes in which impact zones can grow in a round of contact.

    An impact zone is a group of vertices that passed through cloth, and is set back and moved as a whole. If cloth
    still passes through cloth after these passes, the next step resolves it."""


class UntangleOptions(NamedTuple):
    """Settings for separating layers that passed through each other while a hand was closed.

    Many of the lengths are given in thicknesses of the cloth.
    """

    step: float = 0.3
    """Distance by which one pass moves an edge relative to a triangle [thicknesses of the cloth]."""
    most_passes: int = 60
    """Largest number of passes."""
    flattest: float = 1e-3
    """Least sine of the angle between an edge and a triangle [-]. Smaller sines are replaced by this value."""
    blunt: float = 0.1
    """Length of the vector G at which its direction starts to be reliable [-].

    G is the sum of the directions in which an edge should move relative to a triangle. If G is shorter, its direction
    is uncertain, so the edge is moved by clearly less than the distance `step`."""
    shortest: float = 0.7
    """Least length of edges during separation, as a fraction of their rest length [-].

    The membrane would throw shorter edges apart."""
    longest: float = 1.1
    """Largest length of edges during separation, as a fraction of their rest length [-]."""
    slimmest: float = 0.1
    """Smallest height of triangles after separation, as a fraction of the shortest edge [-].

    Bending forces grow with the inverse of the height."""
    length_sweeps: int = 4
    """Number of sweeps in each pass. The sweeps bring the lengths of edges back between `shortest` and `longest`."""
    again_after: float = 0.1
    """Time from one attempt to separate layers to the next attempt [s].

    There is a next attempt if layers are still crossed, or were separated."""


class RestOptions(NamedTuple):
    """Settings of the test whether cloth is at rest.

    Cloth is tested if no hand holds it, and no hand will hold it later. Cloth at rest is not moved any more.
    """

    every: float = 0.1
    """Time between two tests [s]."""
    still: float = 1e-4
    """Limit for the mean displacement of the cloth between two tests [m].

    If the displacement is smaller, the cloth is at rest. With 0, cloth is never at rest."""


class LimitOptions(NamedTuple):
    """Limits at which a rollout is refused or stopped."""

    largest_stretch: float = 1.5
    """Largest stretch of an edge, as a ratio of lengths [-].

    Above it, the membrane model is not valid and a rollout stops."""
    farthest: float = 1e4
    """Largest distance of the cloth from the origin [m]. If the cloth is farther away, the rollout stops."""
    thickest: float = 0.9
    """Largest thickness of the cloth, as a fraction of the shortest edge of the mesh [-].

    Scenes with thicker cloth are refused."""
    most_work: float = 1e12
    """Largest product of the number of time steps and the number of vertices of a rollout.

    Scenes with a larger product are refused. The default corresponds to about two hours."""
    fastest_hand: float = 10.0
    """Highest speed of a hand [m/s]. Targets that need a higher speed are refused.

    Arms move at 2 m/s, and a throw reaches 10 m/s."""
    most_bytes_in_double: float = 64e6
    """Largest size of all frames that are kept in double precision [bytes].

    Larger rollouts are kept in single precision. Single precision rounds one metre by 0.06 micrometres."""


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
    """All settings of this simulator that a study can vary.

    Raises:
        InputError: If a number is negative or not finite, a number that must be positive is zero, or the first sweep of
            contact does not restore the whole distance.
    """

    step: StepOptions = field(default_factory=StepOptions)
    elastic: ElasticOptions = field(default_factory=ElasticOptions)
    contact: ContactOptions = field(default_factory=ContactOptions)
    untangle: UntangleOptions = field(default_factory=UntangleOptions)
    rest: RestOptions = field(default_factory=RestOptions)
    limits: LimitOptions = field(default_factory=LimitOptions)

    def __post_init__(self) -> None:
        """Check all numbers, and convert each to the type of its default, because kernels are compiled for types."""
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
