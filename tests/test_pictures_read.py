"""Pictures of any depth and orientation give the same outline as plain ones; lenses belong to the sensor's pixels."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely
import tifffile
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image, ImageOps

from tatamu.base.errors import InputError
from tatamu.cameras.lens import TURNS, Lens, possible_lenses, turned
from tatamu.garments.photo import find_outline
from tatamu.garments.picture import Picture, read_picture
from tatamu.garments.picture import turned as turned_pixels
from tests.photos import overlap, photograph

LANDSCAPE = Lens(width=1600, height=1200, focal=1400.0, centre=(842.0, 615.0), distortion=(-0.1, 0.02, 1e-3, 2e-3, 0.0))


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> tuple[np.ndarray, np.ndarray]:
    """The pixels of a photo, and its true outline."""
    path = tmp_path_factory.mktemp("plain") / "a.png"
    truth = photograph(path, (215, 205, 190), (90, 70, 60))
    return np.asarray(Image.open(path).convert("RGB")), truth


def grey(pixels: np.ndarray) -> np.ndarray:
    return pixels.mean(axis=2)


DEEP = {
    "12 bits in 16, grey": ("a.png", lambda rgb: np.round(grey(rgb) * 4095 / 255).astype(np.uint16)),
    "10 bits in 16, colour": ("a.png", lambda rgb: np.round(rgb * 1023 / 255.0).astype(np.uint16)),
    "12 bits in 16, colour": ("a.png", lambda rgb: np.round(rgb * 4095 / 255.0).astype(np.uint16)),
    "14 bits in 16, TIFF": ("a.tiff", lambda rgb: np.round(rgb * 16383 / 255.0).astype(np.uint16)),
    "16 bits": ("a.png", lambda rgb: np.round(rgb * 257.0).astype(np.uint16)),
    "16 bits, grey TIFF": ("a.tif", lambda rgb: np.round(grey(rgb) * 257.0).astype(np.uint16)),
    "floats to 1, grey": ("a.tif", lambda rgb: (grey(rgb) / 255).astype(np.float32)),
    "floats to 1": ("a.tif", lambda rgb: (rgb / 255).astype(np.float32)),
    "floats to 255": ("a.tif", lambda rgb: rgb.astype(np.float32)),
    "floats to 4095": ("a.tif", lambda rgb: (rgb * 4095 / 255).astype(np.float32)),
}


@pytest.mark.parametrize("kind", DEEP)
def test_the_range_of_a_deep_picture_is_looked_at(
    kind: str, plain: tuple[np.ndarray, np.ndarray], tmp_path: Path
) -> None:
    pixels, truth = plain
    name, convert = DEEP[kind]
    values = convert(pixels.astype(float))
    assert cv2.imwrite(str(tmp_path / name), values[..., ::-1] if values.ndim == 3 else values)
    read = read_picture(tmp_path / name).pixels
    wanted = pixels if values.ndim == 3 else np.repeat(grey(pixels)[..., None], 3, axis=2)
    bits = values.max() / 255.0 if values.dtype.kind == "u" else 1.0
    assert np.abs(read.astype(float) - wanted).max() <= (3 if bits > 1 else 2) + (255 - pixels.max())
    assert overlap(find_outline(tmp_path / name).outline, truth) > (0.98 if values.ndim == 3 else 0.95)


def test_a_deep_picture_with_alpha_is_cut_out(plain: tuple[np.ndarray, np.ndarray], tmp_path: Path) -> None:
    pixels, _ = plain
    alpha = np.zeros(pixels.shape[:2])
    alpha[100:400, 200:500] = 65535
    deep = np.dstack([pixels[..., ::-1] * (4095 / 255), alpha]).astype(np.uint16)
    cv2.imwrite(str(tmp_path / "a.png"), deep)
    picture = read_picture(tmp_path / "a.png")
    assert picture.alpha is not None and (picture.alpha > 127).sum() == 300 * 300


def test_opencv_prints_nothing_of_a_broken_picture(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    cv2.imwrite(str(tmp_path / "a.tif"), np.full((50, 60, 3), 0.5, np.float32))
    data = (tmp_path / "a.tif").read_bytes()
    start = int.from_bytes(data[4:8], "little")
    end = start + 2 + 12 * int.from_bytes(data[start : start + 2], "little")  # where the offset of the next page stands
    (tmp_path / "a.tif").write_bytes(data[:end] + b"\x03\0\0\0" + data[end + 4 :])
    with suppress(InputError):
        read_picture(tmp_path / "a.tif")
    assert capfd.readouterr() == ("", "")


def test_pixels_that_are_no_numbers_are_one_line(tmp_path: Path) -> None:
    values = np.full((50, 60, 3), 0.5, np.float32)
    values[3, 4] = np.nan
    cv2.imwrite(str(tmp_path / "a.tif"), values)
    with pytest.raises(InputError, match="pixels must be finite"):
        read_picture(tmp_path / "a.tif")


def test_a_defective_pixel_does_not_darken_a_deep_picture(plain: tuple[np.ndarray, np.ndarray], tmp_path: Path) -> None:
    pixels, truth = plain
    for name, values, hot in (("a.png", pixels.astype(np.uint16) * 16, 65535), ("a.tif", pixels / 255.0, 900.0)):
        made = values.astype(np.float32) if name == "a.tif" else values
        made[3, 3] = hot
        cv2.imwrite(str(tmp_path / name), made[..., ::-1])
        assert overlap(find_outline(tmp_path / name).outline, truth) > 0.98


def test_negative_pixels_are_refused(plain: tuple[np.ndarray, np.ndarray], tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.tif"), (plain[0] / 255.0 - 0.5).astype(np.float32))
    with pytest.raises(InputError, match=r"a\.tif: .*at least 0"):
        read_picture(tmp_path / "a.tif")


@pytest.mark.parametrize("kind", [np.uint16, np.float32])
def test_colours_in_planes_of_their_own_are_refused(kind: type, tmp_path: Path) -> None:
    """OpenCV leaves two thirds of the memory as it was."""
    planes: np.ndarray = np.zeros((3, 60, 80), kind)
    tifffile.imwrite(tmp_path / "a.tif", planes, photometric="rgb", planarconfig="separate")
    with pytest.raises(InputError, match="pixel format is not supported; save the picture as an 8-bit PNG"):
        read_picture(tmp_path / "a.tif")


@pytest.mark.parametrize(("stated", "cut_out"), [("unspecified", False), ("unassalpha", True)])
def test_a_fourth_channel_is_alpha_only_if_the_file_says_so(stated: str, cut_out: bool, tmp_path: Path) -> None:
    """It may be infrared."""
    values = np.full((60, 80, 4), 40_000, np.uint16)
    values[10:, :, 3] = 0
    tifffile.imwrite(tmp_path / "a.tif", values, photometric="rgb", extrasamples=[stated])
    assert (read_picture(tmp_path / "a.tif").alpha is not None) is cut_out


@pytest.mark.parametrize("deep", [False, True])
@pytest.mark.parametrize(("pages", "refused"), [((1, 1), True), ((4, 1), True), ((1, 4), False), ((4,), True)])
def test_one_of_several_pages_is_not_chosen_silently(
    pages: tuple[int, ...], refused: bool, deep: bool, tmp_path: Path
) -> None:
    """A smaller page after the first is a preview; raw files of cameras begin with one."""
    values = np.full((120, 160, 3), 99, np.uint16 if deep else np.uint8)
    with tifffile.TiffWriter(tmp_path / "a.tif") as file:
        for step in pages:
            file.write(values[::step, ::step], photometric="rgb", subfiletype=int(step > 1))
    if refused:
        with pytest.raises(InputError, match="must be a single picture, given several or a camera's raw data"):
            read_picture(tmp_path / "a.tif")
    else:
        assert read_picture(tmp_path / "a.tif").pixels.shape == (120, 160, 3)


@pytest.mark.parametrize("size", [(5000, 1), (3, 3000)])
def test_a_line_of_pixels_is_refused(size: tuple[int, int], tmp_path: Path) -> None:
    Image.new("RGB", size).save(tmp_path / "a.png")
    with pytest.raises(InputError, match=r"a\.png: photo: must have .*sides with a ratio of at most 50"):
        find_outline(tmp_path / "a.png")


def test_an_alpha_channel_that_cuts_the_garment_away_is_refused(tmp_path: Path) -> None:
    alpha = np.full((60, 80), 255, np.uint8)
    alpha[10:50, 10:70] = 0
    Image.fromarray(np.dstack([np.zeros((60, 80, 3), np.uint8), alpha])).save(tmp_path / "a.png")
    with pytest.raises(InputError, match="must hide everything around the garment, but shows the picture's border"):
        find_outline(tmp_path / "a.png")


@pytest.mark.parametrize("kind", ["jpg", "png", "tiff", "deep.png", "deep.tiff"])
@pytest.mark.parametrize("tag", range(1, 9))
def test_a_picture_is_upright_and_remembers_its_sensor(kind: str, tag: int, tmp_path: Path) -> None:
    sensor = np.zeros((40, 60, 3), np.uint8)
    sensor[:10, :20] = 250  # the upper left corner of the sensor
    sensor[30:, :20, 0] = 200
    path = tmp_path / f"a.{kind}"
    stated = Image.Exif()
    stated[274] = tag
    if kind.startswith("deep"):
        sensor[...] = sensor[..., :1]
        Image.fromarray(sensor[..., 0].astype(np.uint16) * 257).save(path, exif=stated)
    else:
        Image.fromarray(sensor).save(path, exif=stated, quality=95)
    picture = read_picture(path)
    assert (picture.sensor.shape, picture.orientation) == (sensor.shape, tag)
    assert np.abs(picture.sensor[5:-5:5, 5:-5:5].astype(int) - sensor[5:-5:5, 5:-5:5]).mean() < 20
    image = Image.fromarray(sensor)
    image.getexif()[274] = tag
    wanted = np.asarray(ImageOps.exif_transpose(image))
    assert picture.pixels.shape == wanted.shape
    assert np.array_equal(turned_pixels(sensor, tag), wanted)


@settings(max_examples=60, deadline=None)
@given(tag=st.sampled_from([*TURNS]), x=st.integers(0, 1599), y=st.integers(0, 1199))
def test_a_lens_turns_with_the_picture(tag: int, x: int, y: int) -> None:
    """The pixel of the optical axis is the same place of the picture."""
    lens = LANDSCAPE.model_copy(update={"centre": (float(x), float(y))})
    mark = np.zeros((1200, 1600, 1), bool)
    mark[y, x] = True
    upright = turned_pixels(mark, tag)
    found = turned(lens, tag)
    row, column = np.argwhere(upright[..., 0])[0]
    assert found.centre == (column, row)
    assert (found.height, found.width) == upright.shape[:2]
    back = {6: 8, 8: 6}.get(tag, tag)
    assert turned(found, back).centre == pytest.approx(lens.centre)
    assert turned(found, back).distortion == pytest.approx(lens.distortion)


@pytest.mark.parametrize("tag", [*TURNS])
def test_pixels_are_distorted_alike_before_and_after_turning(tag: int) -> None:
    random = np.random.default_rng(tag)
    points = np.column_stack([random.uniform(-0.3, 0.3, (20, 2)), np.ones(20)])
    sensor = _project(points, LANDSCAPE)
    matrix = np.array(TURNS[tag], float)
    moved = np.column_stack([points[:, :2] @ matrix.T, np.ones(20)])
    size = np.array([1600, 1200])
    new = np.abs(matrix) @ size
    expected = (sensor - 0.5 * (size - 1)) @ matrix.T + 0.5 * (new - 1)
    assert _project(moved, turned(LANDSCAPE, tag)) == pytest.approx(expected, abs=1e-6)


def _project(points: np.ndarray, lens: Lens) -> np.ndarray:
    matrix = np.array([[lens.focal, 0, lens.centre[0]], [0, lens.focal, lens.centre[1]], [0, 0, 1]])
    pixels, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array(lens.distortion))
    return np.asarray(pixels)[:, 0]


def test_a_photo_that_was_turned_without_a_tag_has_two_possible_lenses() -> None:
    found = possible_lenses(LANDSCAPE, (1200, 1600), 1)
    assert [each.centre for each in found] == [pytest.approx((584.0, 842.0)), pytest.approx((615.0, 757.0))]
    assert possible_lenses(LANDSCAPE, (1200, 1600), 6) == [turned(LANDSCAPE, 6)]
    upright = LANDSCAPE.model_copy(update={"width": 1200, "height": 1600, "centre": (590.0, 810.0)})
    assert possible_lenses(upright, (1200, 1600), 6) == [upright]
    with pytest.raises(
        InputError, match=r"lens: must have the aspect ratio of the photo \(1000 x 900 pixels\), given 1600 x 1200"
    ):
        possible_lenses(LANDSCAPE, (1000, 900), 1)


def _saved(pixels: np.ndarray) -> Picture:
    with tempfile.TemporaryDirectory() as folder:
        Image.fromarray(pixels).save(Path(folder) / "a.png")
        return read_picture(Path(folder) / "a.png")


def test_a_plain_picture_is_read_unchanged() -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (30, 40, 3), np.uint8)
    assert np.array_equal(_saved(pixels).pixels, pixels)


STRIPES = {"one": [(300, 340)], "near the middle": [(240, 260)], "many": [(k, k + 12) for k in range(120, 560, 60)]}


@pytest.mark.parametrize("kind", STRIPES)
@pytest.mark.parametrize("upright", [True, False])
def test_a_shirt_that_stripes_divide_is_asked_about(
    kind: str, upright: bool, plain: tuple[np.ndarray, np.ndarray], tmp_path: Path
) -> None:
    pixels, truth = plain
    inside = shapely.contains_xy(shapely.Polygon(truth), *np.meshgrid(np.arange(800), np.arange(600)))
    striped = pixels.copy()
    for start, end in np.array(STRIPES[kind]) + (100 if upright else 0):
        stripe = np.zeros_like(inside)
        stripe[(slice(None), slice(start, end)) if upright else slice(start, end)] = True
        noise = np.random.default_rng(start).normal(0.0, 5.0, (int((stripe & inside).sum()), 3))
        striped[stripe & inside] = np.clip(np.array([90, 70, 60]) + noise, 0, 255)
    Image.fromarray(striped).save(tmp_path / "a.png")
    with pytest.raises(InputError, match=r"regions stand out .*, and the largest has only .* give --join"):
        find_outline(tmp_path / "a.png")
    assert overlap(find_outline(tmp_path / "a.png", join=True).outline, truth) > 0.93


def test_a_wrong_checksum_is_the_only_thing_said(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    deep = np.random.default_rng(0).integers(0, 65_536, (500, 500, 3), dtype=np.uint16)
    data = bytearray(cv2.imencode(".png", deep)[1].tobytes())
    data[data.rindex(b"IEND") - 6] ^= 255  # in the checksum of the last pixels
    (tmp_path / "a.png").write_bytes(data)
    with pytest.raises(InputError, match="checksum"):
        read_picture(tmp_path / "a.png")
    assert capfd.readouterr().err == ""
