"""Symmetric matrices are packed one way."""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.elastic import symmetric


def test_unpacking_undoes_packing() -> None:
    matrices = np.random.default_rng(0).normal(size=(5, 3, 3))
    matrices += matrices.transpose(0, 2, 1)
    packed = symmetric.pack(matrices)
    assert packed.shape == (6, 5)
    assert (symmetric.unpack(packed) == matrices).all()
    assert (packed[:, 2] == matrices[2][np.triu_indices(3)]).all()
