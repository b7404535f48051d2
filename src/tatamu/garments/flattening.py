"""Flattens the mesh of a worn garment: front and back lie in one plane, one over the other, with little distortion.

First, every triangle is assigned to the front, which faces up, or to the back, which faces down. Front and back meet at
folds of the flat garment: at the side seams and along the top of the sleeves.

Then all vertices are moved into the plane. The triangles are rotated, but keep their shapes as well as possible. A
triangle of the back becomes its mirror image. This method is called "as rigid as possible" (Sorkine and Alexa 2007; Liu
et al. 2008 for the plane). The shape to keep is the triangle's shape in the mesh. If the file has a UV map that is the
sewing pattern, the shape in the pattern is kept instead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, maximum_flow
from scipy.sparse.linalg import splu

from tatamu.base.errors import InputError
from tatamu.garments.meshfile import border_loops, pieces
from tatamu.simulation.mesh.topology import Topology

ROUNDS = 400
PASSES, TENSE = 3, 0.3
"""Number of passes in which a garment is flattened, and the relative change of length that doubles a triangle's weight.

After each pass, triangles whose sides changed get more weight. TENSE is the second number.
"""
SMOOTHINGS, SLIVER = 60, 0.12
"""Largest number of passes that correct bad triangles, and the least height of a triangle that is not bad.

The height is a fraction of the triangle's longest side. Triangles that face the wrong way are bad, too.
"""
STILL = 1e-6
"""Largest motion of a vertex in one step at which the flattened garment counts as at rest.

It is a fraction of the garment's extent. The iteration ends when no vertex moves farther in a step.
"""
LEAST_WEIGHT = 0.05
"""Smallest weight of a triangle's side in the flattening of a garment.

The weight is half the cotangent of the opposite angle, but an obtuse angle would give a negative weight.
"""
PRICES = (0.35, 1.0, 3.0)
"""Costs of a mesh edge on the border between front and back, when a garment's triangles are assigned to both.

The unit is the cost of one triangle that faces the wrong way. With a higher cost, the border is shorter and follows
wrinkles less. All costs are tried, and the flat garment with the least strain is kept.
"""
ONE_SIDED = 0.5
"""Limit that decides whether a whole panel of a garment belongs to the front or to the back.

The limit is for the difference between the panel's area that faces up and its area that faces down, divided by its
whole area. Above the limit, the panel is not divided between front and back.
"""


@dataclass(frozen=True)
class Flattened:
    """The mesh of a garment after it was flattened into the plane."""

    plan: np.ndarray
    """Positions of the vertices [m], shape (n, 2)."""
    strain: np.ndarray
    """Relative elongation of each triangle's edges in the plane, compared with the mesh or the sewing pattern, shape
    (m, 3)."""

    wrong: int
    """Number of triangles that face the wrong way: up instead of down, or down instead of up."""

    @property
    def median(self) -> float:
        """Median of the relative changes of the edges' lengths by the flattening."""
        return float(np.median(np.abs(self.strain)))

    @property
    def most(self) -> float:
        """95 % quantile of the relative changes of the edges' lengths by the flattening."""
        return float(np.quantile(np.abs(self.strain), 0.95))


def flattened(points: np.ndarray, faces: np.ndarray, lengths: np.ndarray, panels: np.ndarray) -> Flattened:
    """Flatten a garment into the plane.

    Args:
        points: Vertices in the garment's frame [m], with the front upwards, shape (n, 3).
        faces: Triangles whose normals point out of the garment, shape (m, 3).
        lengths: Desired length of the side opposite each corner of each triangle [m], shape (m, 3).
        panels: Number of the panel to which each triangle belongs, shape (m,).
    """
    divisions = [facing_up(points, faces, panels, price) for price in PRICES]
    distinct = [up for k, up in enumerate(divisions) if not any((up == other).all() for other in divisions[:k])]
    plans = [_laid_out(points[:, :2], faces, lengths, up) for up in distinct]
    return min(plans, key=lambda plan: (plan.wrong, plan.most))


def _laid_out(plan: np.ndarray, faces: np.ndarray, lengths: np.ndarray, up: np.ndarray) -> Flattened:
    """Return a garment that is flattened into the plane, for a given division into front and back.

    The iteration starts from the positions `plan`, shape (n, 2). The mask `up` selects the triangles of the front,
    which must face up in the result.
    """
    stress = np.ones(len(faces))
    for _ in range(PASSES):
        plan = _rigid(plan, faces, _templates(lengths, up), stress)
        turned = _signed(plan, faces) > 0.0  # a triangle next to the fold that does not turn is moved to the other side
        up = turned if _in_one_piece(faces, turned) else up
        strain = side_lengths(plan[faces]) / lengths - 1.0
        stress *= 1.0 + (np.abs(strain).max(axis=1) / TENSE) ** 2
        stress /= stress.mean()
    plan = _turned_right(plan, faces, up)
    wrong = int(_narrow(plan, faces, up, 0.0).sum())
    return Flattened(plan, side_lengths(plan[faces]) / lengths - 1.0, wrong)


def side_lengths(corners: np.ndarray) -> np.ndarray:
    """Return the length of the side opposite each corner of triangles, shape (m, 3); `corners` has shape (m, 3, d)."""
    return np.linalg.norm(np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1), axis=2)


def panel_numbers(faces: np.ndarray, uv: np.ndarray | None) -> np.ndarray:
    """Return the number of the sewing pattern's panel to which each triangle belongs, shape (m,).

    Without a UV map, all triangles belong to panel 0.
    """
    if uv is None:
        return np.zeros(len(faces), dtype=np.int64)
    keys = np.concatenate([np.repeat(faces.reshape(-1, 1), 1, axis=1), np.round(uv.reshape(-1, 2), 6)], axis=1)
    _, corner = np.unique(keys, axis=0, return_inverse=True)
    corner = corner.reshape(-1, 3)
    sides = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
    joined = coo_array((np.ones(len(sides)), sides.T), shape=(corner.max() + 1,) * 2)
    return np.asarray(connected_components(joined, directed=False)[1])[corner[:, 0]]


def facing_up(points: np.ndarray, faces: np.ndarray, panels: np.ndarray, price: float) -> np.ndarray:
    """Return whether each triangle belongs to the front, shape (m,).

    If most of a panel faces one way, the whole panel belongs to that side. Other panels are divided into a part that
    mostly faces up and a part that mostly faces down, with a short border between both parts. Each edge of this border
    has the cost `price`. The division is a minimum cut of the graph of neighbouring triangles.
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
    """Return whether the normals of a garment's triangles point inwards."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), (a + b + c) / 3.0 - points.mean(axis=0))
    return float(outwards.sum()) < 0.0


def _cut(points: np.ndarray, faces: np.ndarray, wish: np.ndarray, price: float) -> np.ndarray:
    """Return whether each triangle belongs to the garment's front, shape (m,).

    The front and the back are the two sides of a minimum cut of the graph of neighbouring triangles.

    A positive `wish` means that the triangle faces the front. Each edge of the border between front and back has the
    cost `price`.
    """
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
    """Return the corners of each triangle, laid in the plane without distortion, as complex numbers, shape (m, 3).

    Triangles that face up are counter-clockwise, and the others are clockwise.
    """
    opposite, b, c = lengths.T  # corner 0 is at 0, corner 1 on the real axis at c
    x = (b**2 + c**2 - opposite**2) / (2.0 * c)
    y = np.sqrt(np.maximum(b**2 - x**2, 1e-6 * c**2))
    corners = np.stack([np.zeros_like(c) + 0j, c + 0j, x + 1j * y], axis=1)
    return np.where(up[:, None], corners, corners.conj())


def _rigid(plan: np.ndarray, faces: np.ndarray, templates: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Return the positions of the vertices in the plane at which all triangles keep their shapes as well as possible.

    Two steps are repeated until convergence. The local step finds the best rotation of each triangle: the phase of a
    weighted sum over its corners, which are complex numbers. The global step finds the best positions of the vertices
    for these rotations, which solve a linear system with a constant matrix. Each triangle has a weight `stress`, shape
    (m,).
    """
    count = len(plan)
    weights = _cotangents(templates) * stress[:, None]
    ahead = np.roll(faces, -1, axis=1)  # start of the side opposite corner k; `behind` is the end
    behind = np.roll(faces, -2, axis=1)
    wished = np.roll(templates, -2, axis=1) - np.roll(templates, -1, axis=1)
    rows = np.concatenate([ahead.ravel(), behind.ravel(), ahead.ravel(), behind.ravel()])
    columns = np.concatenate([ahead.ravel(), behind.ravel(), behind.ravel(), ahead.ravel()])
    values = np.concatenate([weights.ravel(), weights.ravel(), -weights.ravel(), -weights.ravel()])
    stiffness = coo_array((values, (rows, columns)), shape=(count, count)).tocsc()
    stiffness[[0], [0]] = stiffness[0, 0] + 1e-6 * float(weights.max())  # otherwise singular
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
    """Return whether the front and the back are each a single piece of cloth.

    Triangles belong to one piece if they are connected by shared edges. A piece must not touch itself at a vertex.
    """
    for side in (up, ~up):
        try:
            border_loops(faces[side])
        except InputError:
            return False
        if not side.any() or pieces(faces[side]).max() > 0:
            return False
    return True


def _turned_right(plan: np.ndarray, faces: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return the flat positions of the vertices after all inverted or thin triangles have been corrected.

    The corners of such triangles are moved until they are correct.

    A corner moves towards the middle of its neighbours. If the corner lies on the fold between front and back, only
    neighbours along the fold count.
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
    """Return the matrix that computes the mean over the neighbours of each vertex of a mesh, shape (count, count)."""
    both = np.concatenate([edges, edges[:, ::-1]])
    joined = coo_array((np.ones(len(both)), both.T), shape=(count, count)).tocsr()
    number = np.maximum(np.asarray(joined.sum(axis=1)).ravel(), 1.0)
    return csr_array(joined / number[:, None])


def _narrow(plan: np.ndarray, faces: np.ndarray, up: np.ndarray, least: float) -> np.ndarray:
    """Return whether each triangle is too narrow or faces the wrong way, shape (m,).

    A triangle is too narrow if twice its area is at most `least` times the square of its longest side. The area of a
    triangle that faces the wrong way counts as negative.
    """
    area = np.where(up, 1.0, -1.0) * _signed(plan, faces)
    return np.asarray(area <= least * (side_lengths(plan[faces]) ** 2).max(axis=1))


def _cotangents(templates: np.ndarray) -> np.ndarray:
    """Return half the cotangent of the angle at each triangle's corners, but at least `LEAST_WEIGHT`, shape (m, 3)."""
    out = np.empty(templates.shape)
    for k in range(3):
        a, b = (templates[:, (k + j) % 3] - templates[:, k] for j in (1, 2))
        product = a.conj() * b
        out[:, k] = 0.5 * product.real / np.maximum(np.abs(product.imag), 1e-30)
    return np.maximum(out, LEAST_WEIGHT)


def _signed(plan: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return twice the area of each triangle, shape (m,); the area of a triangle that faces down is negative."""
    a, b, c = (plan[faces[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
