"""Choice of the edges that hands should grasp for a fold, so that the hands carry all moving cloth."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.coverage import Part, uncarried
from tatamu.folding.grasps import MIN_DISTANCE, candidates, distances, farthest_edge
from tatamu.folding.layout import Layout


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
