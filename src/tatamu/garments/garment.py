"""Defines a garment: a flat mesh on the table, of one fabric, with one or two layers.

Also limits its size and the edge length ("spacing") of its mesh, and chooses the default spacing.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tatamu.base.errors import InputError
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import facing_down
from tatamu.simulation.scene import Cloth

FINEST_GIVEN = 1e-3
"""Minimum spacing that the user may give [m]."""
MIN_SIDE, MAX_SIDE = 0.05, 5.0
MAX_VERTICES = 50_000


@dataclass(frozen=True)
class GarmentSource:
    """The arguments of `make_garment`, so the garment can be meshed again; None for what the user did not give."""

    name: str
    """Name or file of the garment."""
    size: tuple[float, float] | None = None
    """Width and length [m]."""
    spacing: float | None = None
    """Edge length of the mesh [m]."""
    scale: float | None = None
    """Length of one unit of the garment's file [m]."""
    material: str | None = None
    """Name or file of the material."""


@dataclass(frozen=True)
class Garment:
    """A garment that lies flat on the table, centred at the origin.

    The length is along x and the width along y, with the left side at y > 0 and the hem at x < 0. With the thickness t,
    a single layer is at z = t/2; of two, the back is at t/2, the front at 3t/2, and the seams, which belong to both, at
    t.
    """

    name: str
    size: tuple[float, float]
    """Width (y) and length (x) [m]."""
    spacing: float
    """Typical edge length of the mesh [m]."""
    vertices: np.ndarray
    """Positions of the vertices [m], shape (n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3); the normals of the front point up, those of the back down."""
    material: Material
    seams: np.ndarray = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))
    """Edges of the mesh without bending stiffness, such as seams, shape (s, 2)."""
    rest: np.ndarray | None = None
    """Vertices in the unstrained shape [m], shape (n, 3), both layers at z = 0; None if it is `vertices`."""
    fibre: np.ndarray | None = None
    """Direction of the warp, the lengthwise threads, in the unstrained shape, shape (m, 3) or (1, 3); None for x."""
    edges: dict[str, np.ndarray] = field(default_factory=dict)
    """Named parts of the flat outline, each as a path of vertices, in the upper of two layers."""
    openings: tuple[str, ...] = ()
    """Names of the `edges` at which the layers are not sewn together."""

    own: bool = False
    """Whether the garment came from a user's file, and takes the fold plans of its `kind`, or those for any garment."""
    kind: str = ""
    """Name of the built-in garment whose fold plans a user's garment takes."""
    reading: str = ""
    """Unit of the garment's file, such as "read in inches (DXF, $INSUNITS 1)"."""
    notes: tuple[str, ...] = ()
    """Notes for the user on changes to a garment from a file."""

    source: GarmentSource | None = None
    """The arguments of `make_garment`, if it made the garment."""

    def __repr__(self) -> str:
        return f"<Garment {self.name}: {self.size[0]:.2f} x {self.size[1]:.2f} m, {len(self.vertices)} vertices>"

    @property
    def spacing_given(self) -> bool:
        """Whether the user chose the spacing of the mesh."""
        return self.source is not None and self.source.spacing is not None

    @property
    def layers(self) -> int:
        """Number of layers of cloth."""
        return 2 if facing_down(self.vertices, self.faces).any() else 1

    @property
    def statement(self) -> str:
        """Name and size of the garment, and the unit of its file, in one line."""
        width, length = self.size
        return f"{self.name}: {width:.2f} x {length:.2f} m{', ' if self.reading else ''}{self.reading}"

    def cloth(self) -> Cloth:
        return Cloth(
            vertices=self.vertices, faces=self.faces, rest_vertices=self.rest, seams=self.seams, fibre=self.fibre
        )

    @property
    def unstrained(self) -> np.ndarray:
        """Vertices in the unstrained shape [m], shape (n, 3)."""
        return self.vertices if self.rest is None else self.rest


def spacing_for(material: Material) -> float:
    """Return the mesh spacing that resolves the folds of a material [m]."""
    # folds are accurate up to a spacing of 0.55 bending lengths (docs/theory/bending.md)
    return float(np.clip(material.bending_length / 2.0, 0.004, 0.02))


def default_spacing(material: Material, area: float) -> float:
    """Return the default spacing [m] for an area of all layers [m^2]: fine enough for folds, but not too fine."""
    # more than about 3000 vertices would take longer than minutes; each has an area of sqrt(0.75) squared edge lengths
    return max(spacing_for(material), float(np.sqrt(area / np.sqrt(0.75) / 3_000)))


def check_size(size: tuple[float, float]) -> None:
    """Refuse a width and length [m] that no garment has."""
    for name, side in zip(("width", "length"), size, strict=True):
        if not MIN_SIDE <= side <= MAX_SIDE:
            raise InputError(f"size: {name} must be from {MIN_SIDE:g} to {MAX_SIDE:g} m, given {side:g} m")


def check_spacing(spacing: float, size: tuple[float, float], area: float) -> None:
    """Refuse a spacing [m] that does not suit a size [m] and an area of all layers [m^2]."""
    if not FINEST_GIVEN <= spacing <= largest_spacing(size):
        raise InputError(
            f"spacing: must be from {FINEST_GIVEN:g} m to a quarter of the shorter side ({largest_spacing(size):g} m), "
            f"given {spacing:g} m"
        )
    if area / spacing**2 > 0.8 * MAX_VERTICES:
        raise InputError(
            f"spacing: must give a mesh of at most {MAX_VERTICES} vertices, given {spacing:g} m; give a larger spacing"
        )


def largest_spacing(size: tuple[float, float]) -> float:
    """Return the maximum spacing for a width and length [m]."""
    return min(size) / 4.0
