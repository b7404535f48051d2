"""Push: the test that tells what compression a cloth resists, against the bar with friction."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import InputError, simulate
from tatamu.calibration import advice_on, calibrate
from tatamu.calibration.bias import Bias
from tatamu.calibration.measurements import Measurements
from tatamu.calibration.page import page, shown
from tatamu.calibration.push import Push
from tatamu.calibration.setup import setup_of
from tatamu.simulation.blender.mapping import mapped
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.simulators import Capabilities
from tests.readings import of_towel

CLOTH = Material(
    areal_density=0.2, stretch_stiffness=140.0, bending_rigidity=5e-5, friction_table=0.7, compression=0.15
)
TEST = Push(length=0.6, pushed=0.05)


def told(moved: float | list[float], ahead: float = TEST.length, **more: Any) -> Measurements:
    """What a ruler says of a towel of that cloth: hung, on a board, pushed."""
    length = 0.6
    longer = CLOTH.areal_density * GRAVITY * length**2 / (2 * CLOTH.stretch_stiffness)
    return of_towel(
        (0.3, length),
        CLOTH.areal_density,
        elongation={"grasps": [{"edge": "bottom"}], "L1": length + longer, "L2": length},
        friction={"L_t": 1.0, "H_s": float(np.sin(np.arctan(CLOTH.friction_table)))},
        push={"length": ahead, "pushed": TEST.pushed, "moved": moved},
        **more,
    )


@pytest.mark.parametrize("compression", [1.0, 0.3, 0.15])
def test_a_pushed_cloth_is_shorter_as_a_bar_with_friction_is(compression: float) -> None:
    cloth = CLOTH.model_copy(update={"compression": compression})
    shorter = TEST.pushed - TEST.reading(simulate(TEST.scene(cloth)))
    pressure = cloth.friction_table * cloth.areal_density * GRAVITY
    bar = pressure * TEST.length**2 / (2 * compression * cloth.stretch_stiffness)
    assert shorter == pytest.approx(bar, rel=0.08)
    assert TEST.guess(TEST.pushed - bar, cloth) == pytest.approx(compression)


def test_cloth_that_wrinkles_stays_at_its_far_edge() -> None:
    limp = CLOTH.model_copy(update={"compression": 0.02})
    assert TEST.reading(simulate(TEST.scene(limp))) == pytest.approx(0.0, abs=1e-4)


def test_compression_comes_back_from_its_reading() -> None:
    moved = TEST.reading(simulate(TEST.scene(CLOTH)))
    found = calibrate(told(round(moved, 3)))
    assert found.material.compression == pytest.approx(CLOTH.compression, rel=0.08)
    assert "compression" in found.known and "compression" not in found.assumed
    value, spread = shown(found, "compression")
    assert value.startswith("0.1") and "±" in spread
    places = [found.known.index(name) for name in ("stretch_stiffness", "compression")]
    assert found.correlation()[tuple(places)] < -0.95  # a bar tells c Y, and Y is read to half of itself
    assert found.relative("compression") == pytest.approx(found.relative("stretch_stiffness"), rel=0.1)
    assert "Push: compression c" in page(found)
    assert found.to_toml()["material"]["compression"] == found.material.compression


def test_its_uncertainty_is_that_of_simulated_readings() -> None:
    moved = TEST.reading(simulate(TEST.scene(CLOTH)))
    here, there = (calibrate(told(moved + step)) for step in (0.0, 0.001))
    change = np.log(there.material.compression / here.material.compression)
    assert here.contributions["moved"][4] == pytest.approx(change, rel=0.25)


def test_an_edge_that_stays_bounds_compression() -> None:
    found = calibrate(told(0.0))
    fit = found.fit("push")
    assert fit is not None and fit.bound == "at most"
    assert 0.03 < found.material.compression < 0.15
    assert any("the far edge did not move" in text for text in advice_on(found))


def test_a_cloth_that_slides_as_a_whole_bounds_it_from_below() -> None:
    whole = calibrate(told(TEST.pushed))
    assert whole.fit("push").bound == "at least"  # type: ignore[union-attr]
    assert any("slid as a whole" in text for text in advice_on(whole))


def test_a_bound_from_below_leaves_a_cloth_that_resists_more_as_it_was() -> None:
    found = calibrate(told(TEST.pushed, ahead=0.35))
    fit = found.fit("push")
    assert fit is not None and fit.bound == "at least"
    assert fit.alone is not None and 0.01 < fit.alone < 1.0 and found.material.compression == 1.0
    assert shown(found, "compression") == (f"at least {fit.alone:.4g}", "the reading cannot tell; 1 is taken")
    assert found.to_toml()["bound"] == {"compression": "at least"} and "compression" not in found.known
    assert (
        f"push: within 1.4 mm, the cloth slid as a whole, so c is at least {fit.alone:.2g}, and 1 is used."
        in " ".join(advice_on(found))
    )


def test_a_simulator_without_wrinkles_does_not_use_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.calibration.test.capabilities", lambda simulator: Capabilities(compression=False))
    found = calibrate(told(0.01))
    assert found.fit("push") is None and "compression" in found.assumed and found.material.compression == 1.0
    assert any("not used" in text for text in advice_on(found))


def test_blender_is_told_of_compression() -> None:
    told = mapped(TEST.scene(CLOTH), 0.1).settings
    assert told["compression_stiffness"] == pytest.approx(CLOTH.compression * told["tension_stiffness"])
    assert told["compression_stiffness_max"] == told["compression_stiffness"]
    whole = mapped(TEST.scene(CLOTH.model_copy(update={"compression": 1.0})), 0.1).settings
    assert whole["compression_stiffness"] == whole["tension_stiffness"] == pytest.approx(told["tension_stiffness"])


def test_a_push_is_refused_where_shear_has_a_stiffness_of_its_own(tmp_path: Path) -> None:
    given = told(0.01).model_dump(mode="json", exclude_none=True)
    file = tmp_path / "woven.toml"
    file.write_text(
        "[material]\nareal_density = 0.2\nstretch_stiffness = 300\nbending_rigidity = 1e-5\nshear_stiffness = 30\n"
    )
    given["garment"]["material"] = str(file)
    with pytest.raises(
        InputError, match="push: must be left out for a material with shear_stiffness or stretch_stiffness_weft"
    ):
        setup_of(Measurements.model_validate(given))


BIAS = {"width": 0.05, "L1": 0.31, "L2": 0.3}


def test_beside_a_bias_it_is_not_used_as_no_material_can_have_both() -> None:
    found = calibrate(told(0.01, bias=BIAS))
    assert found.fit("push") is None and "compression" in found.assumed
    assert found.material.shear_stiffness is not None and found.material.compression == 1.0
    assert Material.model_validate(found.material.model_dump()) == found.material
    assert any(text.startswith("push: not used, as cloth with a shear stiffness") for text in advice_on(found))


def test_where_the_bias_cannot_be_simulated_it_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    setup = setup_of(told(0.01, bias=BIAS))
    assert [test.name for test in setup.usable("native")] == ["elongation", "friction", "bias"]
    monkeypatch.setattr(Bias, "unusable", lambda self, simulator: "does not know it")
    assert [test.name for test in setup.usable("native")] == ["elongation", "friction", "push"]
