"""Advice on the unit of a garment's file helps, or is not given."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tatamu.base.errors import InputError
from tatamu.garments import make_garment
from tatamu.garments.garment import MAX_SIDE, MIN_SIDE
from tatamu.garments.units import NAMES, Unit, check_size_of_file, doubts
from tests.foreign import svg
from tests.refusals import refusal

UNITS = st.sampled_from([*NAMES, 7e-5, 25.4])
STRAP = svg('<rect x="2" y="2" width="36" height="696"/>', 40, 700)


def fits(sides: tuple[float, float]) -> bool:
    return MIN_SIDE <= min(sides) and max(sides) <= MAX_SIDE


@given(sides=st.tuples(st.floats(1e-4, 1e4), st.floats(1e-4, 1e4)), metres=UNITS, by_user=st.booleans())
def test_the_scale_that_is_advised_makes_the_garment_fit(
    sides: tuple[float, float], metres: float, by_user: bool
) -> None:
    unit = Unit(metres, "units", "test", by_user)
    try:
        check_size_of_file(sides, "outline", unit)
        said = " ".join(doubts(sides, unit))
    except InputError as error:
        said = str(error)
        assert not fits(sides)
    advised = {float(scale) for scale in re.findall(r"scale (?:= )?([0-9.e+-]+)", said)}
    assert len(advised) <= 1 and metres not in advised
    for scale in advised:
        factor = scale / metres
        assert fits((factor * sides[0], factor * sides[1]))


@pytest.mark.parametrize("scale", [None, 0.001])
def test_a_strap_that_is_too_narrow_is_not_told_to_give_what_was_given(tmp_path: Path, scale: float | None) -> None:
    (tmp_path / "strap.svg").write_text(STRAP)
    said = refusal(make_garment, str(tmp_path / "strap.svg"), scale=scale)
    assert re.search(
        r"given 0\.036 x 0\.696 m.* no usual unit brings both sides "
        "into this range",
        said,
    )
    assert "--scale" not in said


@pytest.mark.parametrize(("factor", "advised"), [(1e-2, "100"), (1e3, "0.001"), (100, "0.01"), (1 / 0.0254, "0.0254")])
def test_a_mesh_of_another_size_is_told_the_right_direction(tmp_path: Path, factor: float, advised: str) -> None:
    import trimesh

    from tatamu.simulation.mesh.meshing import staggered_rectangle

    vertices, faces = staggered_rectangle(0.6, 0.8, 0.03)
    path = tmp_path / "sheet.obj"
    trimesh.Trimesh(vertices * factor, faces, process=False).export(path, digits=12)
    with pytest.raises(InputError, match=rf"--scale {advised} \(metres"):
        make_garment(str(path))
    assert make_garment(str(path), scale=float(advised)).size == pytest.approx((0.8, 0.6), rel=1e-3)
