"""Two-level orthogonal arrays (Plackett and Burman 1946): few rows in which all columns are balanced and orthogonal.

The rows of a Hadamard matrix of order N, whose first column is one, give N scenarios for up to N - 1 disturbances. The
matrices are Paley's (1933), and Sylvester's doubles of them.
"""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError

LEVEL = 1.5
"""Size of the disturbances in the scenarios of a search, in their standard deviations."""


def check_level(level: float) -> None:
    """Raise an InputError if a level is out of range."""
    if not 0.0 < level <= 4.0:
        raise InputError(f"level: must be above 0 and at most 4, given {level:g}")


def orthogonal_array(columns: int) -> np.ndarray:
    """Return an array of plus and minus one, shape (n, columns), with n the next multiple of four above `columns`.

    Arrays are known here for n up to 48; above, n is the next multiple of four for which one is known.
    """
    order = 4 * (columns // 4 + 1)
    while (found := _hadamard(order)) is None:
        order += 4
    return (found * found[:, :1])[:, 1 : columns + 1]


def _hadamard(order: int) -> np.ndarray | None:
    if order in (1, 2):
        return np.array([[1, 1], [1, -1]])[:order, :order]
    if _is_prime(order - 1):
        skew = _bordered(order - 1)
        return skew + np.eye(order, dtype=int)
    half = order // 2
    if _is_prime(half - 1) and half % 4 == 2:
        one = np.eye(half, dtype=int)
        return np.kron(_bordered(half - 1), [[1, 1], [1, -1]]) + np.kron(one, [[1, -1], [-1, -1]])
    smaller = _hadamard(half) if order % 2 == 0 and half % 4 in (0, 2) and half > 1 else None
    return None if smaller is None else np.kron([[1, 1], [1, -1]], smaller)


def _bordered(prime: int) -> np.ndarray:
    """Return the quadratic characters of differences modulo a prime, bordered by ones: Paley's conference matrix."""
    squares = {i * i % prime for i in range(1, prime)}
    character = np.array([0 if i == 0 else 1 if i in squares else -1 for i in range(prime)])
    inner = character[np.subtract.outer(np.arange(prime), np.arange(prime)) % prime]
    border = np.ones(prime, dtype=int)
    side = border if prime % 4 == 1 else -border
    return np.block([[np.zeros((1, 1), dtype=int), border[None]], [side[:, None], inner]])


def _is_prime(number: int) -> bool:
    return number > 2 and all(number % divisor for divisor in range(2, int(number**0.5) + 1))
