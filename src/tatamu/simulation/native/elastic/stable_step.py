"""The fastest vibrations of membrane and bending at rest, which limit the explicit time steps.

Symplectic Euler is stable if the step h times the largest angular frequency omega is below 2. Lanczos iteration finds
omega^2, the largest eigenvalue of G' K G u = omega^2 M u, with the lumped masses M, the stiffness K, and the
derivatives G of strains or angles with respect to the positions.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from tatamu.simulation.native.bands import BLOCK
from tatamu.simulation.native.elastic import bending, membrane, symmetric

SMALL = 40
"""Minimum number of coordinates for Lanczos iteration, which needs more than it has vectors; below it, matrices are
dense."""
TOLERANCE = 1e-2
"""Maximum relative error of omega^2 [-], which the iteration approaches from below."""
ROUNDED_UP = 1.01
"""Factor on the computed frequency, which Lanczos iteration gives too small."""


def hinge_gradients(rest: np.ndarray, hinges: np.ndarray) -> tuple[sparse.csr_array, np.ndarray]:
    """Return d theta / d x, shape (h, 3n), and the measures g, shape (h,), of the hinges in the unstrained shape."""
    count = len(hinges)
    X = np.ascontiguousarray(rest[hinges.T.ravel()].T)
    table = np.array([[0, count, 0, count, 2 * count, 3 * count]])
    measures = bending.scratch(table, count, 0, np.float64)
    bending.measure(X, table, measures)
    rows = measures.gradients.reshape(-1, 8, BLOCK).transpose(1, 0, 2).reshape(8, -1)[:, :count]
    d2, d3, t2, t3 = rows[0:3], rows[3:6], rows[6], rows[7]
    parts = [-(1 - t2) * d2 - (1 - t3) * d3, -t2 * d2 - t3 * d3, d2, d3]
    flat = np.where(np.abs(measures.g) < 1e-9, 0.0, measures.g)
    return _derivatives(np.stack(parts).transpose(2, 0, 1), hinges, len(rest)), flat


def _derivatives(values: np.ndarray, vertices: np.ndarray, count: int) -> sparse.csr_array:
    """Return the derivatives of r values with respect to all positions as a sparse matrix, shape (r, 3 count).

    Each value depends on k vertices, with the derivatives `values`, shape (r, k, 3).
    """
    rows, each = vertices.shape
    columns = (3 * vertices[..., None] + np.arange(3)).astype(np.int32)
    starts = 3 * each * np.arange(rows + 1, dtype=np.int32)
    return sparse.csr_array((values.ravel(), columns.ravel(), starts), shape=(rows, 3 * count))


def membrane_frequency(rest: np.ndarray, faces: np.ndarray, S: np.ndarray, mass: np.ndarray) -> float:
    """Return the maximum angular frequency of the membrane at rest [1/s], with S from `membrane.constants`."""
    count = len(faces)
    ends = faces[:, membrane.ENDS].reshape(-1, 2)
    gradient = _derivatives(membrane.gradients(rest, faces).reshape(-1, 2, 3), ends, len(rest))
    stiffness = sparse.bsr_array((symmetric.unpack(0.5 * S), np.arange(count), np.arange(count + 1)))
    return _largest_frequency(gradient, stiffness, mass)


def bending_frequency(gradient: sparse.csr_array, stiffness: sparse.csr_array, mass: np.ndarray) -> float:
    """Return the maximum angular frequency of bending at rest [1/s]."""
    return _largest_frequency(gradient, stiffness, mass) if stiffness.data.any() else 1e-9


def hinge_stiffness(K: np.ndarray, hinges: np.ndarray, count: int) -> sparse.csr_array:
    """Return the matrix from the angles of all hinges to their moments, the sum of K of all triangles."""
    rows = np.repeat(hinges, 3, axis=1)
    columns = np.tile(hinges, (1, 3))
    return sparse.csr_array((K.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count))


def _largest_frequency(gradient: sparse.csr_array, stiffness: sparse.sparray, mass: np.ndarray) -> float:
    """Return the maximum omega of G' K G u = omega^2 M u [1/s], with G `gradient`, K `stiffness` and M `mass`."""
    scale = 1.0 / np.sqrt(np.repeat(mass, 3))
    size = gradient.shape[1]
    if size < SMALL:
        dense = (gradient.T @ (stiffness @ gradient)).toarray()
        return float(np.sqrt(np.linalg.eigvalsh(dense * scale[:, None] * scale).max()))
    operator = LinearOperator(
        (size, size), matvec=lambda u: scale * (gradient.T @ (stiffness @ (gradient @ (scale * u)))), dtype=float
    )
    start = np.cos(np.arange(size) * 2.399963)  # any fixed vector that contains all frequencies
    top = eigsh(operator, k=1, which="LA", v0=start, tol=TOLERANCE, return_eigenvectors=False)
    return float(ROUNDED_UP * np.sqrt(top[0]))
