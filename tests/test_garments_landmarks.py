"""Hem, sleeves and neck of a T-shirt are found from its outline, and give its layers and its plans."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.folding.advice import choices
from tatamu.folding.plans import PLANS, make_plan
from tatamu.garments import make_garment
from tatamu.garments.landmarks import tshirt_openings
from tatamu.garments.trousers import pattern as trousers_pattern
from tatamu.garments.tshirt import pattern
from tests.commands import command
from tests.photos import SHIRT, photograph

OPEN = ["hem", "left_sleeve", "right_sleeve", "neck"]
V_NECK = np.array([[220, 0], [280, 40], [340, 0], [450, 20], [560, 180], [520, 240], [450, 180], [450, 460]])
V_NECK = np.vstack([V_NECK, V_NECK[::-1] * [-1, 1] + [560, 0]])[1:-1]
LONG = np.array([[320, 0], [410, 20], [500, 160], [700, 420], [650, 460], [470, 250], [430, 190], [440, 520]])
LONG = np.vstack([LONG, LONG[::-1] * [-1, 1] + [560, 0]])
"""With sleeves that bend, and a level neck."""
ENDS = {
    "level neck": (SHIRT, [(110, 460), (430, 460)], [(40, 190), (0, 110)], [(220, 0), (320, 0)]),
    "V neck": (V_NECK, [(110, 460), (450, 460)], [(40, 240), (0, 180)], [(220, 0), (340, 0)]),
    "long sleeves": (LONG, [(120, 520), (440, 520)], [(-90, 460), (-140, 420)], [(240, 0), (320, 0)]),
}


@pytest.mark.parametrize("turn", [0, 3])
@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("kind", ENDS)
def test_openings_are_found_wherever_the_outline_begins(kind: str, way: int, turn: int) -> None:
    outline, hem, left, neck = ENDS[kind]
    points = 1e-3 * np.roll(outline, turn, axis=0)[::way]
    found = {name: points[numbers] for name, numbers in tshirt_openings(points).items()}
    assert list(found) == OPEN
    middle = 0.5e-3 * (outline[:, 0].min() + outline[:, 0].max())
    mirrored = [(2e3 * middle - x, y) for x, y in left]
    for name, ends in (("hem", hem), ("neck", neck), ("left_sleeve", left), ("right_sleeve", mirrored)):
        curve = 1e3 * found[name]
        assert {tuple(end) for end in curve[[0, -1]].round(6).tolist()} == {(float(x), float(y)) for x, y in ends}, name


def test_openings_of_the_built_in_shirt_are_found_again() -> None:
    points = pattern().points
    found = tshirt_openings(np.column_stack([-points[:, 1], -points[:, 0]]))
    for name, numbers in found.items():
        side = pattern().sides["back_neck" if name == "neck" else name]
        assert {tuple(end) for end in points[numbers[[0, -1]]]} == {tuple(end) for end in side[[0, -1]]}, name


@pytest.mark.parametrize("seed", range(5))
def test_noise_of_a_photo_does_no_harm(seed: int) -> None:
    import shapely

    dense = shapely.segmentize(shapely.Polygon(1e-3 * V_NECK), 0.01)
    points = np.array(dense.exterior.coords[:-1])
    points = points + np.random.default_rng(seed).normal(scale=1e-3, size=points.shape)
    found = {name: points[numbers] for name, numbers in tshirt_openings(points).items()}
    for name, ends in (("hem", [(110, 460), (450, 460)]), ("left_sleeve", [(40, 240), (0, 180)])):
        for end in 1e-3 * np.array(ends):
            assert np.linalg.norm(found[name][[0, -1]] - end, axis=1).min() < 0.015, name


@pytest.mark.parametrize(
    ("outline", "words"),
    [
        (np.array([[0, 0], [300, 0], [300, 400], [0, 400]]), "no left sleeve of a T-shirt is found in the photo"),
        (
            np.column_stack([-trousers_pattern().points[:, 1], -trousers_pattern().points[:, 0]]),
            "of a T-shirt is found in the photo",
        ),
        (
            np.where((V_NECK == [0, 180]).all(axis=1)[:, None], [0, 60], V_NECK),
            "both sleeve ends must be about equally wide",
        ),
    ],
)
def test_what_is_no_shirt_is_refused(outline: np.ndarray, words: str) -> None:
    with pytest.raises(InputError, match=words):
        tshirt_openings(1e-3 * outline)


def test_a_shirt_from_a_photo_is_folded_as_a_shirt(tmp_path: Path) -> None:
    photograph(tmp_path / "photo.png", (60, 90, 170), (150, 110, 75))
    said = command(
        "outline", tmp_path / "photo.png", "--width", 0.54, "--garment", "tshirt", "--out", tmp_path / "shirt.svg"
    )
    assert "two layers, open at hem, left_sleeve, right_sleeve, neck" in said
    assert tomllib.loads((tmp_path / "shirt.toml").read_text())["garment"]["kind"] == "tshirt"
    shirt = make_garment(str(tmp_path / "shirt.toml"), spacing=0.03)
    assert shirt.layers == 2
    assert set(shirt.openings) == set(OPEN)
    assert make_plan("shop", shirt) == PLANS["tshirt"]["shop"]
    names = [proposal.plan.name for proposal in choices(shirt)]
    assert names[:2] == ["half", "shop"] and "in-half" in names and len(set(names)) == len(names)
    plain = make_garment(str(tmp_path / "shirt.svg"), spacing=0.03)
    assert set(plain.openings) == set(OPEN)
    with pytest.raises(InputError, match="fold: must be one of"):
        make_plan("shop", plain)


def test_openings_can_be_edited(tmp_path: Path) -> None:
    photograph(tmp_path / "photo.png", (60, 90, 170), (150, 110, 75))
    command("outline", tmp_path / "photo.png", "--width", 0.54, "--garment", "tshirt", "--out", tmp_path / "shirt.svg")
    text = (tmp_path / "shirt.svg").read_text()
    lines = [line for line in text.splitlines() if 'id="left_sleeve"' not in line]
    (tmp_path / "shirt.svg").write_text("\n".join(lines))
    described = (tmp_path / "shirt.toml").read_text().replace('    "left_sleeve",\n', "")
    (tmp_path / "shirt.toml").write_text(described)
    assert set(make_garment(str(tmp_path / "shirt.toml"), spacing=0.03).openings) == {"hem", "right_sleeve", "neck"}


def test_other_garments_are_not_known_by_their_outline(tmp_path: Path) -> None:
    photograph(tmp_path / "photo.png", (60, 90, 170), (150, 110, 75))
    with pytest.raises(InputError, match="--garment: must be tshirt"):
        command("outline", tmp_path / "photo.png", "--width", 0.5, "--garment", "socks", "--out", tmp_path / "a.svg")
    assert not (tmp_path / "a.svg").exists()
