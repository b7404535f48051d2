"""Choice of the edges that hands should grasp for a fold, so that they carry all moving cloth."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from tatamu.errors import InputError
from tatamu.folding.coverage import Part, uncarried
from tatamu.folding.grasps import NEAREST, candidates, distances, farthest_edge
from tatamu.folding.ideal import FoldLine
from tatamu.folding.plan import Step
from tatamu.garments import Garment

TWO_HANDS = 0.15
"""Least length along the fold line of an edge that both hands grasp [m]; a cuff is grasped by one."""
MOST_EDGES = 8
"""Number of edges among which pairs are tried: those farthest from the line."""


def grasp_for(garment: Garment, state: np.ndarray, line: FoldLine) -> tuple[tuple[str, ...], int]:
    """Return the edges to grasp, one or two, and the number of hands.

    The edge farthest from the line is chosen if hands on it carry all moving cloth. Otherwise the choice is the edge,
    or the pair of edges with one for each hand, that leaves the least cloth behind.

    Raises:
        InputError: If no edge lies on the moving side, or the hands do not fit on any.
    """
    plain = (farthest_edge(garment, state, line),)
    hands = 2 if _extent(garment, state, line, plain[0]) >= TWO_HANDS else 1
    try:
        if not covered(garment, state, line, plain, hands):
            return plain, hands
    except InputError:
        hands = 1
    other = other_grasp(garment, state, line)
    return (other, 2) if other else (plain, hands)


def other_grasp(garment: Garment, state: np.ndarray, line: FoldLine) -> tuple[str, ...] | None:
    """Return one edge for both hands, or one for each, that carries all moving cloth; None if no edges do."""
    far = distances(garment, state, line)
    names = sorted(far, key=lambda name: -far[name])[:MOST_EDGES]
    middle = {name: float(line.split(state[garment.edges[name]])[1].mean()) for name in names}
    pairs = [tuple(sorted(pair, key=lambda name: -middle[name])) for pair in combinations(names, 2)]
    for grasp in [*((name,) for name in names), *pairs]:
        try:
            if not covered(garment, state, line, grasp, 2):
                return grasp
        except InputError:  # too short for both hands
            continue
    return None


def covered(
    garment: Garment, state: np.ndarray, line: FoldLine, grasp: tuple[str, ...], hands: int
) -> tuple[Part, ...]:
    """Return the parts that hands on these edges leave behind.

    Raises:
        InputError: If the hands cannot grasp there.
    """
    step = Step.model_validate({"line": ((0.0, 0.0), (0.0, 1.0)), "moves": "-x", "grasp": grasp})
    return uncarried(garment, state, line, candidates(garment, state, line, step, hands)[:hands])


def _extent(garment: Garment, state: np.ndarray, line: FoldLine, edge: str) -> float:
    """Return the length along the line of the far part of an edge [m]."""
    across, along = line.split(state[np.unique(garment.edges[edge])])
    return float(np.ptp(along[-across >= NEAREST * float((-across).max())]))
