"""A disc over a plate: what is read off a photo, what is refused, and bending that comes back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw
from typer.testing import CliRunner

from tatamu.base.errors import InputError
from tatamu.calibration import Measurements, calibrate
from tatamu.calibration.instruments.outline import PlanOutline, centroid
from tatamu.calibration.plate import APART, Plate, length_share
from tatamu.calibration.readings import Errors
from tatamu.cli.app import app
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.presets import load_preset
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.simulators import simulate
from tests.readings import of_towel

PIXELS = 2000.0
"""Per metre, in the photo."""
ANGLES = 2.0 * np.pi * np.arange(720) / 720
RADII = 0.125 + 0.012 * np.cos(7 * ANGLES)
"""Of a hem with seven folds [m]."""


def photographed(path: Path) -> None:
    random = np.random.default_rng(0)
    image = Image.new("RGB", (900, 800), (90, 70, 60))
    hem = np.array([460.0, 390.0]) + PIXELS * RADII[:, None] * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    ImageDraw.Draw(image).polygon([tuple(point) for point in hem], fill=(225, 225, 215))
    noisy = np.asarray(image) + random.normal(0.0, 4.0, (800, 900, 3))
    Image.fromarray(np.clip(noisy, 0, 255).astype(np.uint8)).save(path)


def measurements(**plate: Any) -> Measurements:
    table = {"disc": 0.3, "plate": 0.18, "drape_coefficient": 0.6, **plate}
    return of_towel((0.3, 0.6), 0.2, plate=table)


def asked(path: Path, **more: str) -> list[str]:
    given = {"disc": "0.30", "plate": "0.18", "ruler": "100,20 500,20 0.2", **more}
    return ["measure", "--drape", str(path), *(text for name, value in given.items() for text in (f"--{name}", value))]


def test_a_photo_tells_coefficient_and_folds(tmp_path: Path) -> None:
    photographed(tmp_path / "drape.png")
    result = CliRunner().invoke(app, asked(tmp_path / "drape.png"))
    assert result.exit_code == 0, result.output
    read = dict(line.split(" = ") for line in result.output.splitlines())
    wanted = PlanOutline(RADII).drape_coefficient(0.15, 0.09)
    assert float(read["drape_coefficient"].strip("[]")) == pytest.approx(wanted, abs=0.015)
    assert read["nodes"] == "[7]"


def test_a_photo_in_other_units_is_refused(tmp_path: Path) -> None:
    photographed(tmp_path / "drape.png")
    for more, said in (
        (
            {"ruler": "100,20 500,20 20"},
            "cover more than the plate and less than the disc",
        ),
        ({"plate": "0.4"}, "less than --disc (0.3 m), given 0.4 m"),
    ):
        error = CliRunner().invoke(app, asked(tmp_path / "drape.png", **more)).exception
        assert isinstance(error, InputError) and said in str(error)


def test_the_uncertainty_is_that_of_a_coefficient() -> None:
    table = measurements(drape_coefficient=[0.5, 0.7]).entries()["plate"]
    hem = table.readings(Errors())["hem"]
    test = Plate(0.15, 0.09, 0.6)
    assert test.coefficient_of(hem.value) == pytest.approx(0.6)
    more = test.coefficient_of(hem.value + hem.uncertainty)
    assert more - 0.6 == pytest.approx(0.03 / np.sqrt(2.0), rel=0.02)


def test_stiffer_cloth_keeps_more_of_its_shadow_and_the_guess_is_near() -> None:
    test = Plate(0.15, 0.09, 0.8, spacing=0.012)
    read = []
    for length in (0.018, 0.026):
        rigidity = 0.2 * GRAVITY * length**3
        material = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=rigidity)
        read.append(test.coefficient_of(test.reading(simulate(test.scene(material)))))
        assert length_share(read[-1]) == pytest.approx(length / 0.06, rel=0.15)
    assert read[0] < read[1]


def test_chance_is_how_far_the_discs_are_apart_over_all_simulations() -> None:
    test = Plate(0.15, 0.09, 0.8, spacing=0.012)
    flat = np.array(test.scene(load_preset("terry").material).cloth.rest)
    left = flat[:, 0] < 0.5 * APART * test.disc

    def shape(larger: float) -> np.ndarray:
        """Flat, one disc larger than the other by a part of its radius."""
        middle = np.where(left, 0.0, APART * test.disc)[:, None] * np.eye(3)[0]
        return np.asarray(middle + (flat - middle) * np.where(left, 0.8, 0.8 * (1.0 + larger))[:, None])

    radius = test.reading(Rollout(np.zeros(1), shape(0.0)[None], np.zeros((0, 3), int), {}))
    assert test.chance([shape(0.0)]) == pytest.approx(0.0, abs=1e-4)
    one = test.chance([shape(0.02)])
    assert one == pytest.approx(0.01 * radius, rel=0.05)  # of the mean of two: half of their difference
    assert test.chance([shape(0.02), shape(0.0)]) == pytest.approx(one / np.sqrt(2.0), rel=0.05)


@pytest.mark.slow
def test_a_hidden_rigidity_comes_back_within_twice_its_uncertainty() -> None:
    rigidity = 0.2 * GRAVITY * 0.024**3
    hidden = Material(areal_density=0.2, stretch_stiffness=260.0, bending_rigidity=rigidity)
    true = Plate(0.15, 0.09, 0.8, seed=5)
    coefficient = true.coefficient_of(true.reading(simulate(true.scene(hidden))))
    found = calibrate(measurements(drape_coefficient=[coefficient]))
    error = abs(float(np.log(found.material.bending_rigidity / rigidity)))
    assert error <= 2.0 * found.relative("bending_rigidity") < 0.6


def test_the_middle_of_an_outline_is_that_of_its_area() -> None:
    curve = np.add([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [0.0, 0.5]], [3.0, -1.0])
    assert centroid(curve) == pytest.approx([4.0, -0.5])
