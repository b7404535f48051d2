"""Flattening of a worn garment: front and back in one plane, one over the other, with little distortion.

Triangles are divided into those of the front and those of the back. The front shall face up, and the back shall face
down. Where the two meet, at the side seams and along the top of the sleeves, the garment is folded. Then all vertices
are placed in the plane. Every triangle is to be as near as possible to a rotated copy of itself, or of its mirror image
if it faces down ("as rigid as possible": Sorkine and Alexa 2007; Liu et al. 2008 for the plane). The undeformed
triangle is that of the mesh, or that of the pattern if the file has one as its UV map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, maximum_flow
from scipy.sparse.linalg import splu

from tatamu.errors import InputError
from tatamu.garments.meshfile import border_loops, pieces
from tatamu.topology import Topology

ROUNDS = 400
PASSES, TENSE = 3, 0.3
"""Number of passes, each with more weight on triangles whose sides changed by about this part."""
SMOOTHINGS, SLIVER = 60, 0.12
"""Number of passes that correct triangles facing the wrong way, or with a height below this part of their length."""
STILL = 1e-6
"""Motion below which a vertex has reached its place, as a fraction of the garment's extent."""
LEAST_WEIGHT = 0.05
"""Smallest cotangent weight of an edge: obtuse triangles would have negative ones."""
PRICES = (0.35, 1.0, 3.0)
"""Costs of an edge between front and back, in triangles that face the wrong way. A higher cost makes the border
shorter, and it follows wrinkles less. Each cost is tried, and the plan that strains the garment least is kept."""
ONE_SIDED = 0.5
"""Share of agreeing triangles above which a whole panel belongs to the front or the back."""


@dataclass(frozen=True)
class Flattened:
    """A garment in the plane."""

    plan: np.ndarray
    """Positions of the vertices [m], shape (n, 2)."""
    strain: np.ndarray
    """Relative elongation of the edges of triangles against the mesh or pattern, shape (m, 3)."""

    wrong: int
    """Number of triangles that face the wrong way."""

    @property
    def median(self) -> float:
        """Median relative change of the edges."""
        return float(np.median(np.abs(self.strain)))

    @property
    def most(self) -> float:
        """95 % quantile of the relative change of the edges."""
        return float(np.quantile(np.abs(self.strain), 0.95))


def flattened(points: np.ndarray, faces: np.ndarray, lengths: np.ndarray, panels: np.ndarray) -> Flattened:
    """Lay a garment into the plane.

    Args:
        points: Vertices in a garment's frame [m], its front upwards, shape (n, 3).
        faces: Triangles whose normals point out of the garment, shape (m, 3).
        lengths: Desired lengths of the sides opposite each corner [m], shape (m, 3).
        panels: Number of the panel that each triangle belongs to, shape (m,).
    """
    divisions = [facing_up(points, faces, panels, price) for price in PRICES]
    distinct = [up for k, up in enumerate(divisions) if not any((up == other).all() for other in divisions[:k])]
    plans = [_laid_out(points[:, :2], faces, lengths, up) for up in distinct]
    return min(plans, key=lambda plan: (plan.wrong, plan.most))


def _laid_out(plan: np.ndarray, faces: np.ndarray, lengths: np.ndarray, up: np.ndarray) -> Flattened:
    """Return the garment in the plane, from a first plan (n, 2), with the triangles `up` facing up."""
    stress = np.ones(len(faces))
    for _ in range(PASSES):
        plan = _rigid(plan, faces, _templates(lengths, up), stress)
        turned = _signed(plan, faces) > 0.0  # one beside the fold that will not turn belongs to the other side
        up = turned if _in_one_piece(faces, turned) else up
        strain = side_lengths(plan[faces]) / lengths - 1.0
        stress *= 1.0 + (np.abs(strain).max(axis=1) / TENSE) ** 2
        stress /= stress.mean()
    plan = _turned_right(plan, faces, up)
    wrong = int(_narrow(plan, faces, up, 0.0).sum())
    return Flattened(plan, side_lengths(plan[faces]) / lengths - 1.0, wrong)


def side_lengths(corners: np.ndarray) -> np.ndarray:
    """Lengths of the sides opposite each corner, shape (m, 3), of triangles with corners (m, 3, d)."""
    return np.linalg.norm(np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1), axis=2)


def panel_numbers(faces: np.ndarray, uv: np.ndarray | None) -> np.ndarray:
    """Return the panel of each triangle, shape (m,), by the pattern; one panel without a pattern."""
    if uv is None:
        return np.zeros(len(faces), dtype=np.int64)
    keys = np.concatenate([np.repeat(faces.reshape(-1, 1), 1, axis=1), np.round(uv.reshape(-1, 2), 6)], axis=1)
    _, corner = np.unique(keys, axis=0, return_inverse=True)
    corner = corner.reshape(-1, 3)
    sides = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
    joined = coo_array((np.ones(len(sides)), sides.T), shape=(corner.max() + 1,) * 2)
    return np.asarray(connected_components(joined, directed=False)[1])[corner[:, 0]]


def facing_up(points: np.ndarray, faces: np.ndarray, panels: np.ndarray, price: float) -> np.ndarray:
    """Return whether each triangle belongs to the front, shape (m,), for a `price` of the border to the back.

    A panel that mostly faces one way belongs to that side. Others are divided along the shortest border between
    triangles that face up and down: a minimum cut of the graph of neighbouring triangles.
    """
    a, b, c = (points[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)[:, 2]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    wish = normal.copy()
    for panel in np.unique(panels):
        own = panels == panel
        if panels.max() > 0 and abs(normal[own].sum()) > ONE_SIDED * area[own].sum():
            wish[own] = 10.0 * np.sign(normal[own].sum()) * area[own]
    return _cut(points, faces, wish / area.mean(), price)


def inside_out(points: np.ndarray, faces: np.ndarray) -> bool:
    """Whether the normals of a garment point inwards."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), (a + b + c) / 3.0 - points.mean(axis=0))
    return float(outwards.sum()) < 0.0


def _cut(points: np.ndarray, faces: np.ndarray, wish: np.ndarray, price: float) -> np.ndarray:
    """Return the triangles on the source's side of the minimum cut: mostly those with a positive wish."""
    topology = Topology(faces)
    count = len(faces)
    owner = np.tile(np.arange(count), 3)
    edge = topology.face_edges.T.ravel()
    order = np.argsort(edge, kind="stable")
    paired = order[np.repeat(topology.faces_per_edge, topology.faces_per_edge) == 2].reshape(-1, 2)
    one, other = owner[paired[:, 0]], owner[paired[:, 1]]
    length = np.linalg.norm(np.diff(points[topology.edges[edge[paired[:, 0]]]], axis=1)[:, 0], axis=1)
    weight = np.round(1000.0 * price * length / length.mean()).astype(np.int32)
    wanted = np.round(1000.0 * np.abs(wish)).astype(np.int32)
    ups, downs = np.flatnonzero(wish > 0.0), np.flatnonzero(wish <= 0.0)
    source, sink = count, count + 1
    rows = np.concatenate([one, other, np.full(len(ups), source), downs])
    columns = np.concatenate([other, one, ups, np.full(len(downs), sink)])
    graph = csr_array(
        (np.concatenate([weight, weight, wanted[ups], wanted[downs]]), (rows, columns)), shape=(count + 2, count + 2)
    )
    flow = maximum_flow(csr_array(graph), source, sink).flow
    left = csr_array(graph - flow)
    left.data = np.where(left.data > 0, 1, 0)
    left.eliminate_zeros()
    seen = np.zeros(count + 2, dtype=bool)
    seen[source] = True
    front = seen
    while front.any():
        reached = np.asarray(left.T @ front.astype(np.int64)).ravel() > 0
        front = reached & ~seen
        seen = seen | reached
    return seen[:count]


def _templates(lengths: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return each triangle in the plane, as complex numbers, counter-clockwise if it faces up, shape (m, 3)."""
    opposite, b, c = lengths.T  # of corners 0, 1 and 2: corner 0 lies at 0, corner 1 on the real axis at c
    x = (b**2 + c**2 - opposite**2) / (2.0 * c)
    y = np.sqrt(np.maximum(b**2 - x**2, 1e-6 * c**2))
    corners = np.stack([np.zeros_like(c) + 0j, c + 0j, x + 1j * y], axis=1)
    return np.where(up[:, None], corners, corners.conj())


def _rigid(plan: np.ndarray, faces: np.ndarray, templates: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Return the plan after local and global steps until convergence; triangles have the weights `stress`, shape (m,).

    In complex numbers, the best turn of a triangle is the phase of a weighted sum over its corners (local step). The
    best places of the vertices for given turns solve a linear system with a constant matrix (global step).
    """
    count = len(plan)
    weights = _cotangents(templates) * stress[:, None]
    ahead = np.roll(faces, -1, axis=1)  # of corner k the side opposite it, from its next to its last corner
    behind = np.roll(faces, -2, axis=1)
    wished = np.roll(templates, -2, axis=1) - np.roll(templates, -1, axis=1)
    rows = np.concatenate([ahead.ravel(), behind.ravel(), ahead.ravel(), behind.ravel()])
    columns = np.concatenate([ahead.ravel(), behind.ravel(), behind.ravel(), ahead.ravel()])
    values = np.concatenate([weights.ravel(), weights.ravel(), -weights.ravel(), -weights.ravel()])
    stiffness = coo_array((values, (rows, columns)), shape=(count, count)).tocsc()
    stiffness[[0], [0]] = stiffness[0, 0] + 1e-6 * float(weights.max())  # the plan may lie anywhere
    solve = splu(stiffness)
    pull = (weights * wished).conj().ravel()
    owner = np.repeat(np.arange(len(faces)), 3)
    gather = coo_array(
        (np.concatenate([pull, -pull]), (np.tile(owner, 2), np.concatenate([behind.ravel(), ahead.ravel()]))),
        shape=(len(faces), count),
    ).tocsr()
    spread = gather.conj().T.tocsr()
    place = plan[:, 0] + 1j * plan[:, 1]
    for _ in range(ROUNDS):
        turn = gather @ place
        turn /= np.maximum(np.abs(turn), 1e-30)
        load = spread @ turn
        after = solve.solve(load.real) + 1j * solve.solve(load.imag)
        after += (place - after).mean()
        moved = float(np.abs(after - place).max())
        place = after
        if moved < STILL * float(np.abs(place - place.mean()).max()):
            break
    return np.column_stack([place.real, place.imag])


def _in_one_piece(faces: np.ndarray, up: np.ndarray) -> bool:
    """Whether front and back each hang together by edges, and touch themselves in no vertex."""
    for side in (up, ~up):
        try:
            border_loops(faces[side])
        except InputError:
            return False
        if not side.any() or pieces(faces[side]).max() > 0:
            return False
    return True


def _turned_right(plan: np.ndarray, faces: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return the plan with the corners of inverted or thin triangles moved until they are correct.

    A corner moves towards the middle of its neighbours. If front and back meet there, only neighbours along the fold
    count.
    """
    plan = plan.copy()
    topology = Topology(faces)
    ups = np.bincount(topology.face_edges[up].ravel(), minlength=len(topology.edges))
    fold = topology.edges[(topology.faces_per_edge == 2) & (ups == 1)]
    along, around = _neighbours(fold, len(plan)), _neighbours(topology.edges, len(plan))
    folded = np.isin(np.arange(len(plan)), fold)
    for _ in range(SMOOTHINGS):
        bad = _narrow(plan, faces, up, SLIVER)
        if not bad.any():
            break
        corners = np.unique(faces[bad])
        middle = np.where(folded[:, None], along @ plan, around @ plan)
        plan[corners] = 0.5 * (plan[corners] + middle[corners])
    return plan


def _neighbours(edges: np.ndarray, count: int) -> csr_array:
    """The matrix that takes the mean over the neighbours of each of `count` vertices."""
    both = np.concatenate([edges, edges[:, ::-1]])
    joined = coo_array((np.ones(len(both)), both.T), shape=(count, count)).tocsr()
    number = np.maximum(np.asarray(joined.sum(axis=1)).ravel(), 1.0)
    return csr_array(joined / number[:, None])


def _narrow(plan: np.ndarray, faces: np.ndarray, up: np.ndarray, least: float) -> np.ndarray:
    """Triangles with less area, in their own sense, than half this part of their longest side squared, shape (m,)."""
    area = np.where(up, 1.0, -1.0) * _signed(plan, faces)
    return np.asarray(area <= least * (side_lengths(plan[faces]) ** 2).max(axis=1))


def _cotangents(templates: np.ndarray) -> np.ndarray:
    """Return half the cotangent of each corner, shape (m, 3), at least `LEAST_WEIGHT`."""
    out = np.empty(templates.shape)
    for k in range(3):
        a, b = (templates[:, (k + j) % 3] - templates[:, k] for j in (1, 2))
        product = a.conj() * b
        out[:, k] = 0.5 * product.real / np.maximum(np.abs(product.imag), 1e-30)
    return np.maximum(out, LEAST_WEIGHT)


def _signed(plan: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Twice the area of each triangle, negative where it faces down, shape (m,)."""
    a, b, c = (plan[faces[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
