"""Defines a garment: a flat mesh on the table, of one fabric, with one or two layers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import facing_down
from tatamu.simulation.scene import Cloth


@dataclass(frozen=True)
class GarmentSource:
    """The arguments with which `make_garment` made a garment. They are stored so the garment can be meshed again."""

    name: str
    """Name or file of the garment."""
    size: tuple[float, float] | None = None
    """Width and length given by the user [m]; None for the default size of the garment."""
    spacing: float | None = None
    """Edge length of the mesh given by the user [m]; None for the default."""
    scale: float | None = None
    """Length of one unit of the garment's file [m]; None if the user gave no length."""
    material: str | None = None
    """Name or file of the material; None if the user gave no name or file."""


@dataclass(frozen=True)
class Garment:
    """A garment that lies flat on the table, centred at the origin.

    The length is along x and the width along y, with the left side at y > 0. The hem, which a half fold moves, is at x
    < 0. If the cloth has the thickness t, a single layer is at z = t/2. If there are two layers, the back is at z = t/2
    and the front at z = 3t/2. The vertices of the seams are at z = t, because they belong to both layers.
    """

    name: str
    size: tuple[float, float]
    """Width (y) and length (x) of the flat garment [m]."""
    spacing: float
    """Typical edge length of the mesh [m]."""
    vertices: np.ndarray
    """Positions of the vertices in the flat garment [m], shape (n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3). The normals of the front point up, and the normals of the back point down."""
    material: Material
    seams: np.ndarray = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))
    """Edges of the mesh without bending stiffness, such as seams, shape (s, 2)."""
    rest: np.ndarray | None = None
    """Positions of the vertices in the unstrained shape [m], shape (n, 3); None if this shape is `vertices`.

    If there are two layers, both layers are at z = 0.
    """
    fibre: np.ndarray | None = None
    """Direction of the warp, the lengthwise threads, in the unstrained shape, shape (m, 3) or (1, 3); None for x."""
    edges: dict[str, np.ndarray] = field(default_factory=dict)
    """Named parts of the flat outline, each as a path of vertices. If there are two layers, the path is in the upper
    layer."""
    openings: tuple[str, ...] = ()
    """Names of the `edges` at which the layers are not sewn together."""

    own: bool = False
    """Whether the garment came from a user's file. If true, its fold plans are the plans of its `kind`. If it has no
    `kind`, they are the plans that suit any garment."""
    kind: str = ""
    """Name of the built-in garment whose fold plans this garment uses; empty if the user's file names no garment."""
    reading: str = ""
    """Text on the unit in which the garment's file was read, such as "read in inches (DXF, $INSUNITS 1)"."""
    notes: tuple[str, ...] = ()
    """Notes for the user on changes that were made to a garment from a file."""

    source: GarmentSource | None = None
    """The arguments of `make_garment`; None if the garment was made in another way."""

    def __repr__(self) -> str:
        return f"<Garment {self.name}: {self.size[0]:.2f} x {self.size[1]:.2f} m, {len(self.vertices)} vertices>"

    @property
    def spacing_given(self) -> bool:
        """Whether the spacing (edge length) of the mesh was chosen by the user."""
        return self.source is not None and self.source.spacing is not None

    @property
    def layers(self) -> int:
        """Number of layers of cloth. It is two if some triangles face down, otherwise one."""
        return 2 if facing_down(self.vertices, self.faces).any() else 1

    @property
    def statement(self) -> str:
        """Name and size of the garment in one line. For a garment from a file, the line states the file's unit."""
        width, length = self.size
        return f"{self.name}: {width:.2f} x {length:.2f} m{', ' if self.reading else ''}{self.reading}"

    def cloth(self) -> Cloth:
        """Return the garment as the cloth of a simulation scene."""
        return Cloth(
            vertices=self.vertices, faces=self.faces, rest_vertices=self.rest, seams=self.seams, fibre=self.fibre
        )

    @property
    def unstrained(self) -> np.ndarray:
        """Positions of the vertices in the unstrained shape [m], shape (n, 3)."""
        return self.vertices if self.rest is None else self.rest
