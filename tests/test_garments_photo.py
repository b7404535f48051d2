"""A photo of a flat garment gives its outline, in metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image

from tatamu.base.errors import InputError
from tatamu.garments import make_garment
from tatamu.garments.photo import find_outline, homography, straightened
from tests.commands import command
from tests.photos import PLACE, SCALE, SHIRT, SIZE, TILT, moved, overlap, photograph

WOOD, WHITE, BLUE, RED, BLACK = (150, 110, 75), (240, 240, 240), (60, 90, 170), (200, 60, 60), (40, 40, 45)


@pytest.mark.parametrize(
    ("cloth", "table", "askew"),
    [(BLUE, WOOD, False), (WHITE, WOOD, True), (BLACK, (200, 200, 200), True), (RED, WOOD, True)],
)
def test_the_outline_covers_the_garment(
    cloth: tuple[int, int, int], table: tuple[int, int, int], askew: bool, tmp_path: Path
) -> None:
    truth = photograph(tmp_path / "photo.png", cloth, table, askew=askew)
    found = find_outline(tmp_path / "photo.png").outline
    assert overlap(found, truth) > 0.99
    assert len(found) < 40
    assert shapely.Polygon(found).hausdorff_distance(shapely.Polygon(truth)) < 5.0


def test_a_known_width_gives_metres_and_a_garment(tmp_path: Path) -> None:
    photograph(tmp_path / "photo.png", BLUE, WOOD)
    said = command("outline", tmp_path / "photo.png", "--width", 0.54, "--out", tmp_path / "shirt.svg")
    assert "0.540 m wide" in said
    assert (tmp_path / "shirt-on-photo.jpg").stat().st_size > 10_000
    shirt = make_garment(str(tmp_path / "shirt.svg"), spacing=0.02)
    assert shirt.size == pytest.approx((0.54, 0.46), abs=0.005)


def test_a_ruler_gives_metres(tmp_path: Path) -> None:
    photograph(tmp_path / "photo.png", RED, WOOD)
    ruler = f"10,20 {10 + 500 * SCALE},20 0.5"
    command("outline", tmp_path / "photo.png", "--ruler", ruler, "--out", tmp_path / "shirt.svg")
    assert make_garment(str(tmp_path / "shirt.svg"), spacing=0.02).size == pytest.approx((0.54, 0.46), abs=0.006)


def test_a_sheet_takes_the_perspective_out(tmp_path: Path) -> None:
    photograph(tmp_path / "photo.png", BLUE, WOOD, askew=True)
    sheet = np.array([[0.0, 0.0], [297, 0], [297, 210], [0, 210]])
    corners = moved(sheet * SCALE + PLACE, TILT)
    found = straightened(find_outline(tmp_path / "photo.png").outline, homography(corners, 0.297, 0.210))
    assert overlap(1e3 * found, SHIRT) > 0.99
    text = " ".join("{:.2f},{:.2f}".format(*corner) for corner in corners) + " 0.297x0.210"
    command("outline", tmp_path / "photo.png", "--sheet", text, "--out", tmp_path / "shirt.svg")
    assert make_garment(str(tmp_path / "shirt.svg"), spacing=0.02).size == pytest.approx((0.54, 0.46), abs=0.004)


def test_what_does_not_stand_out_is_refused(tmp_path: Path) -> None:
    photograph(tmp_path / "photo.png", (205, 190, 160), (205, 185, 155))
    with pytest.raises(InputError, match="no garment stands out from the table"):
        find_outline(tmp_path / "photo.png")


def test_a_garment_at_the_border_is_refused(tmp_path: Path) -> None:
    from PIL import Image

    photograph(tmp_path / "photo.png", BLUE, WOOD)
    with Image.open(tmp_path / "photo.png") as photo:
        photo.crop((0, 200, SIZE[1], 480)).save(tmp_path / "cropped.png")
    with pytest.raises(
        InputError,
        match=r"touches the border|no garment stands out|regions stand out",
    ):
        find_outline(tmp_path / "cropped.png")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "--width, --ruler, --sheet: exactly one is needed, given none"),
        (["--width", "0.5", "--ruler", "0,0 1,1 1"], "exactly one is needed, given 2"),
        (["--width", "-1"], "must be a length above 0 m"),
        (["--width", "inf"], "must be a length above 0 m"),
        (["--ruler", " "], "must be two pixels"),
        (["--ruler", "0,0 nan,1 0.5"], "must be a number"),
        (["--sheet", ""], "must be four corners"),
        (["--sheet", "0,0 1,0 1,1 0,1 -0.2x0.3"], "sheet: must have two sides longer than 0 m"),
        (["--ruler", "0,0 0.5"], "must be two pixels"),
        (["--ruler", "0,0 a,1 0.5"], "must be a number"),
        (["--sheet", "0,0 1,1 2,2 3,3 0.2x0.3"], "do not lie on one line"),
        (["--sheet", "0,0 9,9 9,0 0,9 0.2x0.3"], "in the order top left, top right"),
        (["--width", "500"], "all lengths are in metres"),
        (["--ruler", "1,1 1,1 1"], "two different pixels"),
        (["--sheet", "0,0 1,1 0.2x0.3"], "must be four corners"),
    ],
)
def test_wrong_options_are_one_clear_line(options: list[str], words: str, tmp_path: Path) -> None:
    photograph(tmp_path / "photo.png", BLUE, WOOD)
    with pytest.raises(InputError, match=words):
        command("outline", tmp_path / "photo.png", *options, "--out", tmp_path / "shirt.svg")
    assert not (tmp_path / "shirt.svg").exists()


def test_no_picture_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tmp_path = Path()
    (tmp_path / "photo.jpg").write_bytes(b"no picture")
    with pytest.raises(InputError, match="must be a picture"):
        find_outline(tmp_path / "photo.jpg")
    with pytest.raises(InputError, match="cannot be read"):
        find_outline(tmp_path / "none.jpg")
    (tmp_path / "photo.HEIC").write_bytes(b"no picture")
    with pytest.raises(
        InputError, match=r"convert the file to JPEG or PNG, for example with `heif-convert photo.HEIC photo\.png`"
    ):
        find_outline(tmp_path / "photo.HEIC")
    (tmp_path / "my photo;x.heic").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"`heif-convert 'my photo;x\.heic' 'my photo;x\.png'`"):
        find_outline(tmp_path / "my photo;x.heic")
    (tmp_path / "photo.jpg").write_bytes(b"\0\0\0\x1cftypheic\0\0\0\0mif1heic")  # as phones name them after sending
    with pytest.raises(InputError, match=r"heif-convert photo\.jpg photo\.png"):
        find_outline(tmp_path / "photo.jpg")
    (tmp_path / "a b").mkdir()
    (tmp_path / "a b" / "photo.heic").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"heif-convert 'a b/photo\.heic' 'a b/photo\.png'`"):
        find_outline(tmp_path / "a b" / "photo.heic")


def test_sixteen_bits_of_grey_are_read(tmp_path: Path) -> None:
    shades = np.full((300, 400), 60_000, dtype=np.uint16)
    shades[60:240, 80:320] = 8_000
    Image.fromarray(shades).save(tmp_path / "photo.png")
    found = find_outline(tmp_path / "photo.png").outline
    assert np.ptp(found, axis=0) == pytest.approx((240, 180), abs=4)
