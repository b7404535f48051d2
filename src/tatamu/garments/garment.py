"""A garment: a flat mesh on the table, of one fabric, in one layer or two."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tatamu.material import Material
from tatamu.scene import Cloth
from tatamu.topology import facing_down


@dataclass(frozen=True)
class GarmentSource:
    """The arguments of `make_garment` for a garment, by which it can be meshed again."""

    name: str
    """Name or file."""
    size: tuple[float, float] | None = None
    """Width and length as given [m]; None for the garment's own."""
    spacing: float | None = None
    """Spacing as given [m]; None for the garment's own."""
    scale: float | None = None
    """Metres per unit of a file."""
    material: str | None = None
    """Name or file of the material; None if it was not named."""


@dataclass(frozen=True)
class Garment:
    """A garment laid flat and centred at the origin: length along x, width along y, the left at y > 0.

    The hem, the end that a half fold moves, lies at x < 0. One layer lies at z = t/2, t being the thickness; of two
    layers the back lies at t/2, the front at 3t/2, and the vertices of the seams, which belong to both, at t.
    """

    name: str
    size: tuple[float, float]
    """Width (y) and length (x) of the flat garment [m]."""
    spacing: float
    """Typical edge length of the mesh [m]."""
    vertices: np.ndarray
    """Flat positions [m], shape (n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3); normals of the front point up, those of the back down."""
    material: Material
    seams: np.ndarray = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))
    """Edges that hinge freely, shape (s, 2)."""
    rest: np.ndarray | None = None
    """The unstrained shape [m], shape (n, 3); None for `vertices`. Both panels of two layers are at z = 0."""
    fibre: np.ndarray | None = None
    """Direction of the warp in the unstrained shape, shape (m, 3) or (1, 3); None for x, along its length."""
    edges: dict[str, np.ndarray] = field(default_factory=dict)
    """Named parts of the flat outline, each a path of vertices, in the upper of two layers."""
    openings: tuple[str, ...] = ()
    """Names of those `edges` at which two layers are not sewn together."""

    own: bool = False
    """Whether it came from a user's file; it then has the plans of its `kind`, or those of any garment."""
    kind: str = ""
    """The built-in garment whose plans a garment from a user's file has; empty if none."""
    reading: str = ""
    """How the size of a file was read, such as "read in inches (DXF, $INSUNITS 1)"."""
    notes: tuple[str, ...] = ()
    """Changes that were made to a garment from a file, for its user to read."""

    source: GarmentSource | None = None
    """The arguments of `make_garment`; None if it was made in another way."""

    @property
    def spacing_given(self) -> bool:
        """Whether the spacing was chosen by the user."""
        return self.source is not None and self.source.spacing is not None

    @property
    def layers(self) -> int:
        """Number of layers: two if some triangles face down."""
        return 2 if facing_down(self.vertices, self.faces).any() else 1

    @property
    def statement(self) -> str:
        """Name and size of the garment in one line, with the way in which its size was read."""
        width, length = self.size
        return f"{self.name}: {width:.2f} x {length:.2f} m{', ' if self.reading else ''}{self.reading}"

    def cloth(self) -> Cloth:
        """The garment as the cloth of a scene."""
        return Cloth(
            vertices=self.vertices, faces=self.faces, rest_vertices=self.rest, seams=self.seams, fibre=self.fibre
        )

    @property
    def unstrained(self) -> np.ndarray:
        """The unstrained shape [m], shape (n, 3)."""
        return self.vertices if self.rest is None else self.rest
