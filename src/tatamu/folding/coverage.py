"""Finds the parts of the cloth that a fold moves but that no hand carries.

The *moving side* is the cloth on the side of the fold line that is turned over.

Cloth on a table folds over a line like a sheet of paper, and this includes the cloth next to the hands. Cloth that
hangs between a hand and a corner is laid down where it belongs. Two kinds of cloth are not folded this way. A sleeve
that sticks out of the body hangs from its root and trails. A part that is joined to the body only across the fold line
stays where it lies. The following rules decide which cloth is carried. They apply to the cloth as seen from above:

- Cloth is *held* if it belongs to a grasped piece of the moving side and lies between the hands and the fold line. This
  area is the convex hull of the hands and the line.
- Cloth beside the hull is also *held* under three conditions. Its straight path to the fold line lies in the cloth. It
  is no farther from the line than the hands are. Its distance from the hands along the line is no larger than their
  distance from the line.
- Cloth that lies on top of carried cloth is carried with it. An example is a sleeve that was laid on the body.
- The *overhang* of all other cloth is the shortest distance to held cloth, measured through the cloth of the moving
  side.

A part is not carried if it overhangs by more than `LONGEST`. For cloth beyond the hands, away from the fold line, the
limit is `LONGEST_TAIL`. The whole part then stays behind, beginning at its root. The simulations from which these
numbers come are in docs/guide/fold-plans-for-your-garment.md.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from tatamu.folding import layers
from tatamu.folding.ideal import FoldLine
from tatamu.garments import Garment
from tatamu.simulation.mesh.topology import Topology, areas, lumped

OFF = 0.0125
"""Largest distance from its target at which cloth counts as folded [m] (BiFold 2025).

The target is the position after a perfect fold. If cloth at a distance d from the fold line does not move, it remains
at least 2 d away from its target.
"""
LONGEST = 0.15
"""Longest overhang of cloth that is still folded properly [m].

The overhang is the distance to held cloth (cloth that moves with the hands), measured through the cloth.
"""
LONGEST_TAIL = 0.10
"""Longest overhang of cloth farther from the fold line than the hands that is still folded properly [m].

The overhang is the distance to held cloth, measured through the cloth.

The limit is smaller than `LONGEST`. Because hands do not turn, they lay this cloth under the cloth that they carry.
"""
ROOT = 0.03
"""Distance between held cloth and the beginning of a part that no hand carries, measured through the cloth [m]."""
BESIDE = 1.0
"""Largest distance along the fold line between the hands and cloth beside them that still moves with the hands.

The unit is the hands' distance from the fold line.
"""
LEAST_SHARE = 0.01
"""Smallest area of a part that is reported as not carried, as a fraction of the area of the moving cloth."""
SAME_PLACE = 0.7
"""Largest horizontal distance of two vertices that count as one above the other, in edge lengths of the mesh."""
PIXEL = 0.4
"""Size of a pixel in the map that shows where cloth is, in edge lengths of the mesh.

The map is used to find out whether a straight path to the fold line lies in the cloth.
"""
TRIES = 3
"""Number of vertices, from the garment's corner inwards, that are tried as the grasp of each hand."""


@dataclass(frozen=True)
class Part:
    """A part of the cloth that a fold moves but that no hand carries."""

    name: str
    """Names of the garment's edges along the part, or a description of where the part is."""
    low: np.ndarray
    """Smallest x and y in the part before the fold [m], shape (2,)."""
    high: np.ndarray
    """Largest x and y in the part before the fold [m], shape (2,)."""
    area: float
    """Area of the part, in all layers [m^2]."""
    overhang: float
    """Largest distance from the part to cloth that hands hold, measured through the cloth [m].

    It is infinite if no cloth joins the part to the held cloth.
    """
    vertices: np.ndarray
    """Indices of the k vertices of the part, shape (k,)."""

    @property
    def text(self) -> str:
        """Name and extent of the part, in words."""
        (x0, y0), (x1, y1) = self.low, self.high
        how = "not joined to the hands" if np.isinf(self.overhang) else f"{self.overhang:.2f} m beyond the hands"
        return f"{self.name} (x {x0:.2f} to {x1:.2f}, y {y0:.2f} to {y1:.2f} m; {how})"


@dataclass(frozen=True)
class Coverage:
    """The cloth that hands carry if they grasp given vertices."""

    grasps: tuple[int, ...]
    """Indices of the grasped vertices, one for each hand."""
    overhang: np.ndarray
    """Overhang of each vertex: its distance from held cloth, measured through the cloth [m], shape (n,).

    The overhang is 0 for cloth that is held or does not move. It is infinite if no cloth joins the vertex to held
    cloth.
    """
    limit: np.ndarray
    """Largest overhang (distance from held cloth) at which each vertex is still carried [m], shape (n,)."""
    missed: np.ndarray
    """Whether each vertex is far from held cloth and, if it stays in place, far from its target, shape (n,).

    A vertex is far from held cloth if its overhang is larger than `ROOT`. It is far from its target if the distance is
    larger than `OFF`.
    """

    @property
    def lost(self) -> np.ndarray:
        """Whether each vertex is not carried: it is in `missed`, and its overhang is above its limit, shape (n,)."""
        return self.missed & (self.overhang > self.limit)


def uncarried(
    garment: Garment,
    state: np.ndarray,
    line: FoldLine,
    hands: tuple[np.ndarray, ...],
) -> tuple[Part, ...]:
    """Return the parts of the cloth that a fold moves but that no hand carries, largest first.

    Args:
        garment: The garment to fold.
        state: The cloth before the fold [m], shape (n, 3).
        line: The fold line and its moving side.
        hands: For each hand, an array of the m vertices that it may grasp, from the garment's corner inwards.
    """
    hold = best_coverage(garment, state, line, hands)
    return parts_of(garment, state, line, hold)


def best_coverage(garment: Garment, state: np.ndarray, line: FoldLine, hands: tuple[np.ndarray, ...]) -> Coverage:
    """Return the cloth that hands carry with the best pair of grasps, which leaves the least cloth behind."""
    cloth = _Cloth.of(garment, state, line)
    count = min(len(hand) for hand in hands)
    tried = np.unique(np.linspace(0, count - 1, TRIES).round().astype(int))
    pairs = [tuple(int(hand[k]) for hand in hands) for k in tried]
    holds = [cloth.hold(pair) for pair in pairs]
    return min(holds, key=lambda hold: float(cloth.weight[hold.lost].sum()))


def parts_of(garment: Garment, state: np.ndarray, line: FoldLine, hold: Coverage) -> tuple[Part, ...]:
    """Return the connected parts of the cloth that no hand carries.

    A part is left out if its distance from held cloth is within the limit everywhere, or its area is very small.
    """
    missed = np.flatnonzero(hold.missed)
    weight = vertex_areas(garment)
    moving = line.split(state)[0] < 0
    least = LEAST_SHARE * float(weight[moving].sum())
    place = np.full(len(state), -1)
    place[missed] = np.arange(len(missed))
    links = place[np.concatenate([Topology(garment.faces).edges, _stacked(state, missed, garment.spacing)])]
    links = links[(links >= 0).all(axis=1)]
    graph = csr_array((np.ones(len(links)), links.T), shape=(len(missed), len(missed)))
    number, label = connected_components(graph, directed=False)
    parts = []
    for each in range(number):
        vertices = missed[label == each]
        area = float(weight[vertices].sum())
        overhang = float(hold.overhang[vertices].max())
        if area < least or not hold.lost[vertices].any():
            continue
        plan = state[vertices, :2]
        name = _name(garment, vertices, plan)
        parts.append(Part(name, plan.min(axis=0), plan.max(axis=0), area, overhang, vertices))
    return tuple(sorted(parts, key=lambda part: (-round(part.area, 6), part.name)))


def vertex_areas(garment: Garment) -> np.ndarray:
    """Return the area of cloth that belongs to each vertex: a third of the area of its triangles [m^2], shape (n,)."""
    flat = garment.unstrained
    return lumped(areas(flat, garment.faces), garment.faces, len(flat))


@dataclass(frozen=True)
class _Cloth:
    """The moving side of a cloth as a graph: vertices with links between them.

    Its links are the edges of the mesh, with their lengths. Further links of length zero lead from each vertex up to
    the vertices that lie on top of it.
    """

    line: FoldLine
    places: np.ndarray
    """Distance of each vertex from the fold line, and its coordinate along the line [m], shape (n, 2)."""
    moving: np.ndarray
    """Whether each vertex is on the moving side of the fold line, shape (n,)."""
    weight: np.ndarray
    """Area of the cloth that belongs to each vertex [m^2], shape (n,)."""
    pieces: np.ndarray
    """Index of the piece of cloth to which each vertex belongs, shape (n,).

    A piece is a connected part of the moving side. Vertices that stay have the index -1."""
    graph: csr_array
    """Length of the link between each two vertices that are linked [m], shape (n, n)."""
    region: np.ndarray
    """Triangles of the moving side, as indices of their vertices, shape (m, 3)."""
    spacing: float
    straight: dict[int, np.ndarray] = field(default_factory=dict)
    """For each piece of the moving side: whether each vertex has a straight path through the cloth to the fold line.

    Each entry has the shape (n,).

    It is computed at its first use and then kept.
    """

    @classmethod
    def of(cls, garment: Garment, state: np.ndarray, line: FoldLine) -> _Cloth:
        across, along = line.split(state)
        moving = across < 0
        count = len(state)
        edges = Topology(garment.faces).edges
        edges = edges[moving[edges].all(axis=1)]
        lengths = np.linalg.norm(state[edges[:, 0]] - state[edges[:, 1]], axis=1)
        stacked = _stacked(state, np.flatnonzero(moving), garment.spacing)
        rows = np.concatenate([edges[:, 0], edges[:, 1], stacked[:, 0]])
        columns = np.concatenate([edges[:, 1], edges[:, 0], stacked[:, 1]])
        values = np.concatenate([lengths, lengths, np.full(len(stacked), 1e-9)])
        graph = csr_array((values, (rows, columns)), shape=(count, count))
        mesh = csr_array((np.ones(len(edges)), edges.T), shape=(count, count))
        pieces = np.where(moving, connected_components(mesh, directed=False)[1], -1)
        places = np.column_stack([across, along])
        triangles = garment.faces[moving[garment.faces].any(axis=1)]
        return cls(line, places, moving, vertex_areas(garment), pieces, graph, triangles, garment.spacing)

    def hold(self, grasps: tuple[int, ...]) -> Coverage:
        """Return the cloth that hands carry if they grasp these vertices."""
        overhang = np.full(len(self.places), np.inf)
        held = np.zeros(len(self.places), dtype=bool)
        for piece, members in self._pinched(grasps).items():
            own = self.pieces == piece
            if piece not in self.straight:
                self.straight[piece] = self._straight(own)
            held |= own & self._inside(own, members, self.straight[piece])
        if held.any():
            overhang = dijkstra(self.graph, indices=np.flatnonzero(held), min_only=True)
        overhang[~self.moving] = 0.0
        missed = self.moving & (overhang > ROOT) & (-2.0 * self.places[:, 0] > OFF)
        beyond = self.places[:, 0] < self._farthest(grasps) - 0.5 * self.spacing
        return Coverage(grasps, overhang, np.where(beyond, LONGEST_TAIL, LONGEST), missed)

    def _farthest(self, grasps: tuple[int, ...]) -> float:
        """Find the hand that is farthest from the fold line, and return its coordinate perpendicular to this line [m].

        The coordinate is negative, because hands are on the moving side.
        """
        return float(self.places[list(grasps), 0].min())

    def _pinched(self, grasps: tuple[int, ...]) -> dict[int, list[int]]:
        """Return the grasps that hold each piece of the moving cloth, by the number of the piece.

        A piece is a connected part of the moving side. If several pieces lie on each other, fingers hold all of them.
        """
        found: dict[int, list[int]] = {}
        for grasp in grasps:
            near = np.linalg.norm(self.places - self.places[grasp], axis=1) < SAME_PLACE * self.spacing
            for piece in np.unique(self.pieces[near & self.moving]):
                found.setdefault(int(piece), []).append(grasp)
        return found

    def _inside(self, own: np.ndarray, grasps: list[int], straight: np.ndarray) -> np.ndarray:
        """Return which vertices of a piece of cloth move with the hands, shape (n,).

        A vertex moves with the hands if it lies between the grasps and the fold line. A vertex beside this area moves
        with them if it is near enough to the grasps, and its straight path to the fold line lies in the cloth.
        """
        at_line = own & (self.places[:, 0] > -1.5 * self.spacing)
        hands = self.places[grasps]
        corners = [*hands]
        if at_line.any():
            ends = self.places[at_line, 1]
            corners += [np.array([0.0, ends.min()]), np.array([0.0, ends.max()])]
        hull = shapely.MultiPoint(np.array(corners)).convex_hull.buffer(0.51 * self.spacing)
        inside = shapely.contains_xy(hull, *self.places.T)
        reach = BESIDE * float(-hands[:, 0].min())
        along = self.places[:, 1]
        beside = (along > hands[:, 1].min() - reach) & (along < hands[:, 1].max() + reach)
        beside &= self.places[:, 0] >= hands[:, 0].min() - 0.5 * self.spacing
        return np.asarray(inside | (beside & straight))

    def _straight(self, own: np.ndarray) -> np.ndarray:
        """Return which vertices of a piece have a straight path through the cloth to the fold line, shape (n,)."""
        triangles = self.region[own[self.region].any(axis=1)]
        pixel = PIXEL * self.spacing
        shrunk = np.column_stack([layers.PIXEL / pixel * self.places, np.ones(len(self.places))])
        cloth = layers.Surface.of(shrunk, triangles, 0.0, layers.PIXEL)
        low, high = self.places[own].min(axis=0), self.places[own].max(axis=0)
        across = np.arange(0.5, -low[0] / pixel + 1.0) * -pixel
        along = np.arange(low[1], high[1] + pixel, pixel)
        grid = np.stack(np.meshgrid(across, along, indexing="ij"), axis=-1)
        covered = cloth.height(layers.PIXEL / pixel * grid.reshape(-1, 2)) > 0
        straight = np.logical_and.accumulate(covered.reshape(grid.shape[:2]))
        row = np.clip((-self.places[:, 0] / pixel).astype(int), 0, len(across) - 1)
        column = np.clip(np.round((self.places[:, 1] - low[1]) / pixel).astype(int), 0, len(along) - 1)
        return np.asarray(own & straight[row, column])


def _stacked(state: np.ndarray, vertices: np.ndarray, spacing: float) -> np.ndarray:
    """Return k pairs of vertices that lie over each other, the lower vertex first, shape (k, 2)."""
    if not len(vertices):
        return np.empty((0, 2), dtype=np.int64)
    tree = cKDTree(state[vertices, :2])
    pairs = vertices[tree.query_pairs(SAME_PLACE * spacing, output_type="ndarray")]
    below = state[pairs[:, 0], 2] <= state[pairs[:, 1], 2]
    pairs = np.where(below[:, None], pairs, pairs[:, ::-1])
    return np.asarray(pairs[np.abs(np.diff(state[pairs, 2], axis=1)[:, 0]) > 1e-9].reshape(-1, 2))


def _name(garment: Garment, vertices: np.ndarray, plan: np.ndarray) -> str:
    """Describe a part of the cloth by the named edges that lie in it.

    The edge with the largest fraction of its vertices in the part comes first. If no named edge lies in the part, the
    description states where the part is.
    """
    inside = set(vertices.tolist())
    shares = {name: np.mean([int(v) in inside for v in path]) for name, path in garment.edges.items()}
    whole = [name for name in sorted(shares, key=lambda name: -shares[name]) if shares[name] > 0.5]
    if whole:
        return f"the part with {' and '.join(whole[:2])}"
    x, y = plan.mean(axis=0)
    return f"the part about x {x:.2f}, y {y:.2f} m"
