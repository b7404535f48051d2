"""Bending on every layout of a mesh, by statics: the sag of a cantilever that bends a little."""

from __future__ import annotations

import pytest

from tests import statics
from tests.physics.meshes import LAYOUTS


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_cantilever_sags_right_on_every_layout(layout: str) -> None:
    assert statics.tip(LAYOUTS[layout], 0.01) == pytest.approx(1.0, abs=0.015)
    assert statics.tip(LAYOUTS[layout], 0.005) == pytest.approx(1.0, abs=0.004)


@pytest.mark.slow
def test_meshes_that_no_check_has_are_right_on_average() -> None:
    for layouts in statics.OTHERS.values():
        tips = [statics.tip(layout, 0.005) for layout in layouts]
        assert sum(tips) / len(tips) == pytest.approx(1.0, abs=0.003)
        assert max(abs(tip - 1.0) for tip in tips) < 0.012


@pytest.mark.parametrize("layout", ["right triangles at 45 deg", "irregular"])
def test_the_two_operators_of_curvature_err_to_opposite_sides(layout: str) -> None:
    assert statics.tip(LAYOUTS[layout], 0.005, statics.PARTS["R^-1"]) > 1.02
    assert statics.tip(LAYOUTS[layout], 0.005, statics.PARTS["C"]) < 0.98
