"""Flattens the mesh of a worn garment: front and back lie in one plane, one over the other, with little distortion.

First, every triangle is assigned to the front, which faces up, or to the back. They meet at folds of the flat garment:
at the side seams and along the top of the sleeves. Then all vertices are moved into the plane, and the triangles keep
their shapes "as rigid as possible" (Sorkine and Alexa 2007; Liu et al. 2008 for the plane), those of the back as mirror
images. The shapes are those in the mesh, or in the UV map if it is the sewing pattern.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow
from scipy.sparse.linalg import splu

from tatamu.base.errors import InputError
from tatamu.garments.meshfile import border_loops, fold_edges, pieces
from tatamu.simulation.mesh.topology import Topology, areas, edge_lengths, twice_areas


@dataclass(frozen=True)
class Flattened:
    """A garment that was flattened into the plane."""

    plan: np.ndarray
    """Positions of the vertices [m], shape (n, 2)."""
    strain: np.ndarray
    """Relative elongation of each triangle's edges, compared with the mesh or the pattern, shape (m, 3)."""

    wrong: int
    """Number of triangles that face the wrong way."""

    @property
    def median(self) -> float:
        """Median relative change of the edges' lengths."""
        return float(np.median(np.abs(self.strain)))

    @property
    def most(self) -> float:
        """95 % quantile of the relative changes of the edges' lengths."""
        return float(np.quantile(np.abs(self.strain), 0.95))


def flattened(points: np.ndarray, faces: np.ndarray, lengths: np.ndarray, panels: np.ndarray) -> Flattened:
    """Flatten a garment into the plane.

    Args:
        points: Vertices in the garment's frame [m], with the front upwards, shape (n, 3).
        faces: Triangles whose normals point out of the garment, shape (m, 3).
        lengths: Desired length of the side opposite each corner [m], shape (m, 3).
        panels: Index of each triangle's panel, shape (m,).
    """
    # a higher price gives a shorter border; the flat garment with the least strain is kept
    divisions = [facing_up(points, faces, panels, price) for price in (0.35, 1.0, 3.0)]
    distinct = [up for k, up in enumerate(divisions) if not any((up == other).all() for other in divisions[:k])]
    plans = [_laid_out(points[:, :2], faces, lengths, up) for up in distinct]
    return min(plans, key=lambda plan: (plan.wrong, plan.most))


def _laid_out(plan: np.ndarray, faces: np.ndarray, lengths: np.ndarray, up: np.ndarray) -> Flattened:
    """Return the flat garment for a division into front (`up`) and back, from positions `plan` [m], shape (n, 2)."""
    stress = np.ones(len(faces))
    for _ in range(3):
        plan = _rigid(plan, faces, _templates(lengths, up), stress)
        turned = twice_areas(plan, faces) > 0.0  # if it stays so, a triangle next to the fold changes its side
        up = turned if _in_one_piece(faces, turned) else up
        strain = side_lengths(plan[faces]) / lengths - 1.0
        # a change of 30 % doubles a triangle's weight in the next pass
        stress *= 1.0 + (np.abs(strain).max(axis=1) / 0.3) ** 2
        stress /= stress.mean()
    plan = _turned_right(plan, faces, up)
    wrong = int(_narrow(plan, faces, up, 0.0).sum())
    return Flattened(plan, side_lengths(plan[faces]) / lengths - 1.0, wrong)


def side_lengths(corners: np.ndarray) -> np.ndarray:
    """Return the length of the side opposite each corner of triangles, shape (m, 3); `corners` has shape (m, 3, d)."""
    return np.linalg.norm(np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1), axis=2)


def panel_numbers(faces: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return the index of each triangle's panel in the sewing pattern, shape (m,)."""
    keys = np.column_stack([faces.ravel(), np.round(uv.reshape(-1, 2), 6)])
    _, corner = np.unique(keys, axis=0, return_inverse=True)
    return pieces(corner.reshape(-1, 3))


def facing_up(points: np.ndarray, faces: np.ndarray, panels: np.ndarray, price: float) -> np.ndarray:
    """Return whether each triangle belongs to the front, shape (m,).

    A panel that mostly faces one way belongs to that side. Others are divided by a minimum cut of the graph of
    neighbouring triangles, in which each edge of the border has the cost `price`.
    """
    normal, area = twice_areas(points, faces), 2.0 * areas(points, faces)
    wish = normal.copy()
    for panel in np.unique(panels):
        own = panels == panel
        # otherwise the panel is divided between front and back
        if panels.max() > 0 and abs(normal[own].sum()) > 0.5 * area[own].sum():
            wish[own] = 10.0 * np.sign(normal[own].sum()) * area[own]
    return _cut(points, faces, wish / area.mean(), price)


def inside_out(points: np.ndarray, faces: np.ndarray) -> bool:
    """Return whether the normals of a garment's triangles point inwards."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), (a + b + c) / 3.0 - points.mean(axis=0))
    return float(outwards.sum()) < 0.0


def _cut(points: np.ndarray, faces: np.ndarray, wish: np.ndarray, price: float) -> np.ndarray:
    """Return the sides of a minimum cut of the graph of neighbouring triangles, shape (m,); True for the front.

    A positive `wish` means that the triangle faces the front. Each edge of the border has the cost `price`.
    """
    topology = Topology(faces)
    count = len(faces)
    one, other = topology.neighbours.T
    length = edge_lengths(points, topology.inner_edges)
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
    seen[breadth_first_order(left, source, return_predecessors=False)] = True
    return seen[:count]


def _templates(lengths: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return each triangle's corners, laid in the plane, as complex numbers, shape (m, 3); clockwise for the back."""
    opposite, b, c = lengths.T  # corner 0 is at 0, corner 1 on the real axis at c
    x = (b**2 + c**2 - opposite**2) / (2.0 * c)
    y = np.sqrt(np.maximum(b**2 - x**2, 1e-6 * c**2))
    corners = np.stack([np.zeros_like(c) + 0j, c + 0j, x + 1j * y], axis=1)
    return np.where(up[:, None], corners, corners.conj())


def _rigid(plan: np.ndarray, faces: np.ndarray, templates: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Return the vertices in the plane at which all triangles keep their shapes as well as possible, shape (n, 2).

    Two steps are repeated until convergence. The local step finds the best rotation of each triangle: the phase of a
    weighted sum over its corners. The global step solves a linear system with a constant matrix for the vertices. Each
    triangle has the weight `stress`, shape (m,).
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
    for _ in range(400):
        turn = gather @ place
        turn /= np.maximum(np.abs(turn), 1e-30)
        load = spread @ turn
        after = solve.solve(load.real) + 1j * solve.solve(load.imag)
        after += (place - after).mean()
        moved = float(np.abs(after - place).max())
        place = after
        if moved < 1e-6 * float(np.abs(place - place.mean()).max()):
            break
    return np.column_stack([place.real, place.imag])


def _in_one_piece(faces: np.ndarray, up: np.ndarray) -> bool:
    """Return whether front and back are each one piece, connected by edges, that nowhere touches itself at a vertex."""
    for side in (up, ~up):
        try:
            border_loops(faces[side])
        except InputError:
            return False
        if not side.any() or pieces(faces[side]).max() > 0:
            return False
    return True


def _turned_right(plan: np.ndarray, faces: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return the vertices after the corners of inverted or thin triangles were moved until these are good.

    A corner moves towards the middle of its neighbours; on the fold between front and back, of those along the fold.
    """
    plan = plan.copy()
    topology = Topology(faces)
    fold = fold_edges(topology, up)
    along, around = _neighbours(fold, len(plan)), _neighbours(topology.edges, len(plan))
    folded = np.isin(np.arange(len(plan)), fold)
    for _ in range(60):
        bad = _narrow(plan, faces, up, 0.12)
        if not bad.any():
            break
        corners = np.unique(faces[bad])
        middle = np.where(folded[:, None], along @ plan, around @ plan)
        plan[corners] = 0.5 * (plan[corners] + middle[corners])
    return plan


def _neighbours(edges: np.ndarray, count: int) -> csr_array:
    """Return the matrix that takes the mean over each vertex's neighbours, shape (count, count)."""
    both = np.concatenate([edges, edges[:, ::-1]])
    joined = coo_array((np.ones(len(both)), both.T), shape=(count, count)).tocsr()
    number = np.maximum(np.asarray(joined.sum(axis=1)).ravel(), 1.0)
    return csr_array(joined / number[:, None])


def _narrow(plan: np.ndarray, faces: np.ndarray, up: np.ndarray, least: float) -> np.ndarray:
    """Return whether each triangle faces the wrong way, or is at most `least` times as high as its longest side."""
    area = np.where(up, 1.0, -1.0) * twice_areas(plan, faces)
    return np.asarray(area <= least * (side_lengths(plan[faces]) ** 2).max(axis=1))


def _cotangents(templates: np.ndarray) -> np.ndarray:
    """Return half the cotangent of each triangle's angles, but at least 0.05, shape (m, 3)."""
    out = np.empty(templates.shape)
    for k in range(3):
        a, b = (templates[:, (k + j) % 3] - templates[:, k] for j in (1, 2))
        product = a.conj() * b
        out[:, k] = 0.5 * product.real / np.maximum(np.abs(product.imag), 1e-30)
    return np.maximum(out, 0.05)  # an obtuse angle would give a negative weight
