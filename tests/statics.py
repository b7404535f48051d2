"""Linear statics of bending: the sag of a strip that is held by its middle row, under a load of 1 per area, B = 1."""

from __future__ import annotations

from functools import partial

import numpy as np

from tatamu.simulation.mesh.topology import Topology, areas, lumped
from tatamu.simulation.native.elastic import curvature, membrane
from tatamu.simulation.native.elastic.stable_step import hinge_gradients, hinge_stiffness
from tatamu.simulation.native.options import ElasticOptions
from tests.physics.meshes import Layout, irregular, mirrored, turned
from tests.physics.scenes import raised

LENGTH, WIDTH = 0.10, 0.06
PARTS = {"R^-1": 0.0, "C": 1.0, "Q": ElasticOptions().angle_sum_part}
"""Fraction of C in the operator that gives curvatures."""
OTHERS: dict[str, list[Layout]] = {
    "8 more irregular": [partial(irregular, seed=seed) for seed in range(2, 10)],
    "6 more angles": [partial(turned, degrees=angle) for angle in (7.0, 13.0, 20.0, 26.0, 35.0, 41.0)],
}
"""Meshes that no textbook check has: the part of C in Q was chosen on them."""


def tip(layout: Layout, spacing: float, angle_sum_part: float = PARTS["Q"]) -> float:
    """Sag of the tip over the exact w L^4 / 8 B, for B = w = 1."""
    plan, faces = mirrored(layout(LENGTH, WIDTH, spacing))
    rest, topology = raised(plan), Topology(faces)
    free = np.zeros(len(topology.hinges), dtype=bool)
    curved = curvature.maps(rest, topology, membrane.rest_frames(rest, faces), free, angle_sum_part)
    K = curvature.stiffness(curved, np.diag([1.0, 1.0, 2.0]))
    at = curved.hinges
    G = hinge_gradients(rest, topology.hinges)[0][:, 2::3]
    loose = np.abs(plan[:, 0]) > 1e-12  # all but the middle row, about which a load on both sides turns nothing
    turn = plan[loose, 0] / np.linalg.norm(plan[loose, 0])
    S = (G.T @ hinge_stiffness(K, at, len(topology.hinges)) @ G).toarray()[np.ix_(loose, loose)]
    sag = np.zeros(len(plan))
    load = lumped(areas(rest, faces), faces, len(rest))[loose]
    sag[loose] = np.linalg.solve(S + S.diagonal().mean() * np.outer(turn, turn), load)
    return float(sag[np.abs(plan[:, 0]) > LENGTH - 1e-9].mean() / (LENGTH**4 / 8))
