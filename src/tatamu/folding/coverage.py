"""The parts of the cloth that a fold moves but no hand carries, and edges to grasp so that hands carry all of it.

Cloth folds over a line like a sheet of paper, beside the hands as well. There are two exceptions: a sleeve that sticks
out of the body hangs from its root and trails, and a part that is joined to the body only across the fold line stays
where it lies. So these rules decide, on the cloth as seen from above:

- Cloth is *held* if it belongs to a grasped piece of the moving side and lies in the convex hull of the hands and the
  fold line.
- Cloth beside the hull is held, too, if its straight path to the fold line lies in the cloth, it is no farther from the
  line than the hands, and its distance from the hands along the line is no larger than theirs from the line.
- Cloth on top of carried cloth is carried with it, such as a sleeve that was laid on the body.
- The *overhang* of all other cloth is its shortest distance to held cloth, through the cloth of the moving side.

A part stays behind, from its root, if it overhangs by more than `MAX_OVERHANG`, or by `MAX_TAIL` if it is farther from
the fold line than the hands. Both come from simulations (docs/guide/fold-plans-for-your-garment.md).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from tatamu.base.errors import InputError
from tatamu.folding import layers
from tatamu.folding.grasps import MIN_DISTANCE, candidates, distances, farthest_edge, links_within
from tatamu.folding.layout import Layout
from tatamu.garments import Garment
from tatamu.simulation.mesh.topology import Topology, areas, connected, lumped

OFF = 0.0125
"""Maximum distance from its target at which cloth counts as folded [m] (BiFold 2025). Cloth at a distance d from the
fold line that does not move is at least 2 d away from its target."""
MAX_OVERHANG = 0.15
"""Maximum overhang of cloth that is still folded properly [m]."""
MAX_TAIL = 0.10
"""The same for cloth beyond the hands [m]. Because hands do not turn, they lay it under the cloth that they carry."""
ROOT = 0.03
"""Overhang at which a part that no hand carries begins [m]."""
SAME_PLACE = 0.7
"""Maximum horizontal distance of vertices that lie one above the other, in edge lengths of the mesh."""


@dataclass(frozen=True)
class Part:
    """A part of the cloth that a fold moves but that no hand carries."""

    name: str
    """Names of the garment's edges along the part, or where the part is."""
    low: np.ndarray
    """Minimum x and y before the fold [m], shape (2,)."""
    high: np.ndarray
    area: float
    """Area of all layers [m^2]."""
    overhang: float
    """Maximum overhang [m]; infinite if no cloth joins the part to held cloth."""
    vertices: np.ndarray

    @property
    def text(self) -> str:
        (x0, y0), (x1, y1) = self.low, self.high
        how = "not joined to the hands" if np.isinf(self.overhang) else f"{self.overhang:.2f} m beyond the hands"
        return f"{self.name} (x {x0:.2f} to {x1:.2f}, y {y0:.2f} to {y1:.2f} m; {how})"


@dataclass(frozen=True)
class Coverage:
    """The cloth that hands carry with given grasps."""

    overhang: np.ndarray
    """Overhang of each vertex [m], shape (n,): 0 if held or still, infinite if no cloth joins it to held cloth."""
    limit: np.ndarray
    """Maximum overhang at which each vertex is still carried [m], shape (n,)."""
    missed: np.ndarray
    """Whether each vertex, shape (n,), overhangs by more than `ROOT` and, if it stays, is over `OFF` from its target.
    """

    @property
    def lost(self) -> np.ndarray:
        return self.missed & (self.overhang > self.limit)


def grasp_for(layout: Layout) -> tuple[tuple[str, ...], int]:
    """Return the one or two edges that hands should grasp, and the number of hands.

    The edge farthest from the fold line is chosen if hands on it carry all moving cloth, or if no grasp does. Otherwise
    another edge is chosen, or a pair of which each hand grasps one.
    """
    plain = (farthest_edge(layout),)
    hands = 2 if _extent(layout, plain[0]) >= 0.15 else 1  # one hand grasps a cuff
    try:
        if not covered(layout, plain, hands):
            return plain, hands
    except InputError:
        hands = 1
    other = other_grasp(layout)
    return (other, 2) if other else (plain, hands)


def other_grasp(layout: Layout) -> tuple[str, ...] | None:
    """Return a grasp that carries all moving cloth: an edge for both hands, or one for each; None if there is none."""
    far = distances(layout)
    names = sorted(far, key=lambda name: -far[name])[:8]
    middle = {name: float(layout.split(layout.garment.edges[name])[1].mean()) for name in names}
    pairs = [tuple(sorted(pair, key=lambda name: -middle[name])) for pair in combinations(names, 2)]
    for grasp in [*((name,) for name in names), *pairs]:
        try:
            if not covered(layout, grasp, 2):
                return grasp
        except InputError:  # The edge is too short for both hands.
            continue
    return None


def covered(layout: Layout, grasp: tuple[str, ...], hands: int) -> tuple[Part, ...]:
    """Return the parts of the moving cloth that stay behind if hands grasp these edges."""
    return uncarried(layout, candidates(layout, grasp, hands)[:hands])


def _extent(layout: Layout, edge: str) -> float:
    across, along = layout.split(np.unique(layout.garment.edges[edge]))
    return float(np.ptp(along[-across >= MIN_DISTANCE * float((-across).max())]))


def uncarried(layout: Layout, hands: tuple[np.ndarray, ...]) -> tuple[Part, ...]:
    """Return the connected parts of the cloth that a fold moves but that no hand carries, largest first.

    Each of `hands` has the vertices that it may grasp, from the garment's corner inwards. Tiny parts do not count.
    """
    garment, state = layout.garment, layout.state
    hold = best_coverage(layout, hands)
    missed = np.flatnonzero(hold.missed)
    weight = vertex_areas(garment)
    least = 0.01 * float(weight[layout.split()[0] < 0].sum())  # smaller parts are not reported
    edges = np.concatenate([Topology(garment.faces).edges, _stacked(state, missed, garment.spacing)])
    links = links_within(edges, missed, len(state))
    part = connected(links, len(missed))
    parts = []
    for vertices in (missed[part == each] for each in np.unique(part)):
        area = float(weight[vertices].sum())
        if area >= least and hold.lost[vertices].any():
            plan = state[vertices, :2]
            overhang = float(hold.overhang[vertices].max())
            name = _name(garment, vertices, plan)
            parts.append(Part(name, plan.min(axis=0), plan.max(axis=0), area, overhang, vertices))
    return tuple(sorted(parts, key=lambda part: (-round(part.area, 6), part.name)))


def best_coverage(layout: Layout, hands: tuple[np.ndarray, ...]) -> Coverage:
    """Return the cloth that is carried with the pair of grasps that leaves the least behind."""
    cloth = _Cloth.of(layout)
    count = min(len(hand) for hand in hands)
    tried = np.unique(np.linspace(0, count - 1, 3).round().astype(int))
    holds = [cloth.hold(tuple(int(hand[k]) for hand in hands)) for k in tried]
    return min(holds, key=lambda hold: float(cloth.weight[hold.lost].sum()))


def vertex_areas(garment: Garment) -> np.ndarray:
    """Return the area that belongs to each vertex [m^2], shape (n,): a third of its triangles'."""
    flat = garment.unstrained
    return lumped(areas(flat, garment.faces), garment.faces, len(flat))


@dataclass(frozen=True)
class _Cloth:
    """The moving side as a graph: the edges of the mesh, and a link of length 0 up to every vertex on top."""

    places: np.ndarray
    """Distance of each vertex from the fold line, and its coordinate along the line [m], shape (n, 2)."""
    moving: np.ndarray
    weight: np.ndarray
    """Area that belongs to each vertex [m^2], shape (n,)."""
    pieces: np.ndarray
    """Index of the connected piece of the moving side that each vertex belongs to, shape (n,); -1 if it stays."""
    graph: csr_array
    """Lengths of the links between vertices [m], shape (n, n)."""
    region: np.ndarray
    """Triangles of the moving side, shape (m, 3)."""
    spacing: float
    straight: dict[int, np.ndarray] = field(default_factory=dict)
    """Results of `_straight` for each piece, computed at their first use."""

    @classmethod
    def of(cls, layout: Layout) -> _Cloth:
        garment, state, (across, along) = layout.garment, layout.state, layout.split()
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
        pieces = np.where(moving, connected(edges, count), -1)
        places = np.column_stack([across, along])
        triangles = garment.faces[moving[garment.faces].any(axis=1)]
        return cls(places, moving, vertex_areas(garment), pieces, graph, triangles, garment.spacing)

    def hold(self, grasps: tuple[int, ...]) -> Coverage:
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
        farthest = float(self.places[list(grasps), 0].min())  # of the hands
        beyond = self.places[:, 0] < farthest - 0.5 * self.spacing
        return Coverage(overhang, np.where(beyond, MAX_TAIL, MAX_OVERHANG), missed)

    def _pinched(self, grasps: tuple[int, ...]) -> dict[int, list[int]]:
        """Return the grasps that hold each piece, by its index. Fingers hold all pieces that lie on each other."""
        found: dict[int, list[int]] = {}
        for grasp in grasps:
            near = np.linalg.norm(self.places - self.places[grasp], axis=1) < SAME_PLACE * self.spacing
            for piece in np.unique(self.pieces[near & self.moving]):
                found.setdefault(int(piece), []).append(grasp)
        return found

    def _inside(self, own: np.ndarray, grasps: list[int], straight: np.ndarray) -> np.ndarray:
        """Return which vertices of a piece are held, shape (n,), by the rules for the hull and for cloth beside it."""
        at_line = own & (self.places[:, 0] > -1.5 * self.spacing)
        hands = self.places[grasps]
        corners = [*hands]
        if at_line.any():
            ends = self.places[at_line, 1]
            corners += [np.array([0.0, ends.min()]), np.array([0.0, ends.max()])]
        hull = shapely.MultiPoint(np.array(corners)).convex_hull.buffer(0.51 * self.spacing)
        inside = shapely.contains_xy(hull, *self.places.T)
        reach = float(-hands[:, 0].min())
        along = self.places[:, 1]
        beside = (along > hands[:, 1].min() - reach) & (along < hands[:, 1].max() + reach)
        beside &= self.places[:, 0] >= hands[:, 0].min() - 0.5 * self.spacing
        return np.asarray(inside | (beside & straight))

    def _straight(self, own: np.ndarray) -> np.ndarray:
        """Return which vertices of a piece have a straight path through the cloth to the fold line, shape (n,)."""
        triangles = self.region[own[self.region].any(axis=1)]
        pixel = 0.4 * self.spacing  # in the map of the cloth
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
    """Return k pairs of vertices that lie over each other, the lower one first, shape (k, 2)."""
    if not len(vertices):
        return np.empty((0, 2), dtype=np.int64)
    tree = cKDTree(state[vertices, :2])
    pairs = vertices[tree.query_pairs(SAME_PLACE * spacing, output_type="ndarray")]
    below = state[pairs[:, 0], 2] <= state[pairs[:, 1], 2]
    pairs = np.where(below[:, None], pairs, pairs[:, ::-1])
    return np.asarray(pairs[np.abs(np.diff(state[pairs, 2], axis=1)[:, 0]) > 1e-9].reshape(-1, 2))


def _name(garment: Garment, vertices: np.ndarray, plan: np.ndarray) -> str:
    """Return the named edges in a part, the one with most of its vertices there first, or else where the part is."""
    inside = set(vertices.tolist())
    shares = {name: np.mean([int(v) in inside for v in path]) for name, path in garment.edges.items()}
    whole = [name for name in sorted(shares, key=lambda name: -shares[name]) if shares[name] > 0.5]
    if whole:
        return f"the part with {' and '.join(whole[:2])}"
    x, y = plan.mean(axis=0)
    return f"the part about x {x:.2f}, y {y:.2f} m"
