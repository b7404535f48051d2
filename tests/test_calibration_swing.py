"""Cloth held by two corners and let go: air that was hidden comes back, and what cannot be is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.calibration import Calibration, Measurements, advice_on, calibrate
from tatamu.calibration.fading import Fading, FadingReadings
from tatamu.calibration.page import page
from tatamu.calibration.swing import TenSwings
from tatamu.garments import make_garment
from tatamu.simulation.simulators import simulate
from tests.readings import of_towel

SIZE = (0.24, 0.36)
AIR = {"areal_density": 0.3, "air_added_mass": 0.12, "air_drag_quadratic": 1.5}
SPACING = 0.03


def measurements(**tables: Any) -> Measurements:
    return of_towel(SIZE, AIR["areal_density"], **tables)


def truth() -> tuple[float, float]:
    """What a stopwatch and a ruler would read of the hidden air."""
    garment = make_garment("towel", size=SIZE, spacing=SPACING)
    hidden = garment.material.model_copy(update=AIR)
    ten = TenSwings(garment, "bottom", 0.08, None)
    fading = Fading(garment, "bottom", 0.08, 0.02, 4.0)
    return (ten.reading(simulate(ten.scene(hidden))), fading.reading(simulate(fading.scene(hidden))))


@pytest.fixture(scope="module")
def found() -> Calibration:
    seconds, count = truth()
    swing = {"edge": "bottom", "aside": 0.08, "ten_swings": seconds}
    fading = {"edge": "bottom", "aside": 0.08, "to": 0.02, "count": [count]}
    return calibrate(measurements(swing=swing, fading=fading), spacing=SPACING)


def test_swings_are_one_number_or_a_list_of_them() -> None:
    fading = {"edge": "bottom", "aside": 0.08, "to": 0.02}
    one, listed = (FadingReadings.model_validate({**fading, "count": count}) for count in (3.0, [3.0]))
    assert one == listed


def test_hidden_air_comes_back_within_its_uncertainty(found: Calibration) -> None:
    for name in ("air_added_mass", "air_drag_quadratic"):
        off = np.log(getattr(found.material, name) / AIR[name])
        assert abs(off) <= found.relative(name) < 0.5, name
    assert found.material.air_drag == 0.0


def test_its_page_shows_seconds_and_counts(found: Calibration) -> None:
    text = page(found)
    assert "Ten swings measured" in text and "Swings counted" in text
    assert "time of ten swings [s]" in text
    assert {"air_added_mass", "air_drag_quadratic"} <= set(found.listed)
    assert found.to_toml()["uncertainty"].keys() >= {"air_added_mass", "air_drag_quadratic"}


def test_swings_faster_than_without_air_bound_it() -> None:
    swing = {"edge": "bottom", "aside": 0.08, "ten_swings": 8.0}
    found = calibrate(measurements(swing=swing), spacing=SPACING)
    assert found.bounding("air_added_mass") is not None
    assert any(
        "faster than the cloth swings without air" in text or "but the reading asks for" in text
        for text in advice_on(found)
    )


def test_optional_parameters_are_not_spoken_of_where_nothing_tells_them() -> None:
    found = calibrate(measurements(friction={"L_t": 1.0, "H_s": 0.5}), spacing=SPACING)
    text = str(found.to_toml()["calibration"]) + str(found.to_toml()["uncertainty"])
    assert "air_added_mass" not in text and "air_added_mass" not in found.listed


def test_it_cannot_be_drawn_aside_farther_than_it_is_long() -> None:
    with pytest.raises(InputError, match="aside"):
        calibrate(measurements(swing={"edge": "bottom", "aside": 0.3, "ten_swings": 12.0}))
