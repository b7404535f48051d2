"""A photograph of cloth beside a board gives pose, size and outline; wrong boards and photographs are one line."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image, ImageDraw

import tatamu as tt
from tatamu.base.errors import InputError
from tatamu.cameras.board import DOTS, Board, load_board, page, write_board, write_pdf
from tatamu.cameras.camera import estimate
from tatamu.cameras.edges import Line
from tatamu.cameras.lens import Lens, calibrate_lens, load_lens, scaled, write_lens
from tatamu.cameras.locate import Located, locate_shape
from tatamu.cameras.markers import find_pages, saddles
from tatamu.cameras.photograph import read_photograph
from tatamu.cameras.pictures import draw_reading
from tatamu.cameras.pose import Pose, parse_pose, parse_touched, touched_pose
from tatamu.cameras.reading import FoldReader, FoldReading
from tatamu.cameras.shape import lay, shape_of
from tatamu.folding.fold import Fold
from tatamu.folding.score import marks
from tatamu.folding.task import make_task
from tatamu.garments import make_garment
from tests.commands import command
from tests.photographs import Cloth, Paper, Shot, laid, photograph
from tests.refusals import refusal

PAGES = Board(pages=2)
PLACE = Pose(0.62, 0.42, 0.2)
SMALL = (0.20, 0.30)
SHOT = Shot(size=(1000, 750), tilt=30.0, distance=1.0, target=(0.42, 0.24), distortion=(0.02, -0.01), seed=1, finer=1)
PAPERS = (Paper(PAGES), Paper(PAGES, 1, Pose(0.72, 0.0, 0.1)))


def towel(**looks: object) -> Cloth:
    garment = make_garment("towel", size=SMALL, spacing=0.03)
    return laid(garment.vertices, garment.faces, PLACE, **looks)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A photograph of a towel between two pages of a board, and the board's file."""
    folder = tmp_path_factory.mktemp("photographs")
    Image.fromarray(photograph(SHOT, towel(), PAPERS)).save(folder / "towel.png")
    write_board(PAGES, folder / "board.toml", folder / "board.pdf")
    write_board(Board(), folder / "one.toml", folder / "one.pdf")
    return folder


@pytest.fixture(scope="module")
def located(folder: Path) -> Located:
    return tt.locate(folder / "towel.png", folder / "board.toml", size=SMALL, board_pose=(0.3, -0.2, 0.5))


def test_a_towel_is_found_where_it_lies(located: Located) -> None:
    assert (located.pose.x, located.pose.y) == pytest.approx((PLACE.x, PLACE.y), abs=0.002)
    assert located.pose.yaw == pytest.approx(PLACE.yaw, abs=np.radians(0.5))
    assert located.size == pytest.approx(SMALL, abs=0.003)
    outline = shapely.LinearRing(located.outline)
    truth = Pose(0.3, -0.2, 0.5).place(PLACE.place(0.5 * np.array(SMALL)[::-1] * [[1, 1], [1, -1], [-1, -1], [-1, 1]]))
    assert outline.hausdorff_distance(shapely.LinearRing(truth)) < 0.003
    assert located.corners["top-left"] == pytest.approx(truth[0], abs=0.002)


def test_errors_are_as_large_as_stated(located: Located) -> None:
    off = np.array([located.pose.x - PLACE.x, located.pose.y - PLACE.y, located.pose.yaw - PLACE.yaw])
    assert (np.abs(off) < 3.0 * np.array(located.deviation)).all()
    assert max(located.deviation[:2]) < 0.003


def test_the_place_is_the_garments_pose_in_the_robots_frame(located: Located) -> None:
    assert located.place is not None
    inside = located.pose.place(np.array([[0.1, 0.02]]))
    assert located.place.place(np.array([[0.1, 0.02]])) == pytest.approx(Pose(0.3, -0.2, 0.5).place(inside))


def test_without_lens_and_second_page_the_pose_is_stated_to_be_worse() -> None:
    true = SHOT.camera()
    smooth = photograph(replace(SHOT, finer=2), None, PAPERS)  # pixels that are no means of rays move corners
    edge = true.project(np.column_stack([PLACE.place(0.5 * np.array([[0.3, 0.2], [0.3, -0.2]])), np.zeros(2)]))
    seen = find_pages(np.asarray(Image.fromarray(smooth).convert("L")), PAGES)
    lens = Lens(width=1000, height=750, focal=800, centre=(499.5, 374.5), distortion=(0.02, -0.01))
    views = [estimate(seen[:1], SHOT.size), estimate(seen, SHOT.size), estimate(seen[:1], SHOT.size, lens)]
    off = [np.linalg.norm(v.camera.on_table(edge) - true.on_table(edge), axis=1).max() for v in views]
    stated = [v.deviation(edge).max() for v in views]
    assert stated[0] > 2.0 * max(stated[1:])
    assert (np.array(off) < 3.0 * np.array(stated)).all()
    assert max(off[1:]) < 0.001


def test_the_command_writes_a_place_pictures_and_a_file(folder: Path) -> None:
    touched = Pose(0.3, -0.2, 0.5).place(PAGES.marks)
    said = command(
        "locate", folder / "towel.png", "--board", folder / "board.toml", "--size", "0.20x0.32",
        "--touch", " ".join(f"{x:.4f},{y:.4f}" for x, y in touched),
        "--picture", folder / "look.jpg", "--from-above", folder / "top.png", "--out", folder / "located.json",
    )  # fmt: skip
    place = [float(part) for part in said.partition("--place ")[2].split()[0].split(",")]
    assert place == pytest.approx([*Pose(0.3, -0.2, 0.5).place(np.array([[PLACE.x, PLACE.y]]))[0], 0.7], abs=0.01)
    assert ("length -6." in said and "another size" in said) or "area is too small" in said
    assert json.loads((folder / "located.json").read_text())["place"]["yaw"] == pytest.approx(0.7, abs=0.01)
    with Image.open(folder / "look.jpg") as look, Image.open(folder / "top.png") as top:
        assert look.size == (1000, 750) and top.width > 200


def test_a_corner_turned_in_is_refused_unless_it_is_shown(tmp_path: Path, folder: Path) -> None:
    garment = make_garment("towel", size=SMALL, spacing=0.02)
    points = garment.vertices.copy()
    inside = (points[:, 0] - 0.15) + (points[:, 1] - 0.10) + 0.07  # beyond the line by which the corner is turned in
    turned = inside > 0
    points[turned, :2] -= inside[turned, None] * [1.0, 1.0]
    points[turned, 2] += 0.003
    Image.fromarray(photograph(SHOT, laid(points, garment.faces, PLACE), PAPERS)).save(tmp_path / "turned.png")
    with pytest.raises(InputError, match="corner top-left must lie flat, but is turned in"):
        tt.locate(tmp_path / "turned.png", folder / "board.toml")
    pixel = SHOT.camera().project(np.array([[*PLACE.place(np.array([[0.15, 0.10]]))[0], 0.001]]))[0]
    found = tt.locate(tmp_path / "turned.png", folder / "board.toml", corners={"top-left": pixel})
    assert (found.pose.x, found.pose.y) == pytest.approx((PLACE.x, PLACE.y), abs=0.003)
    with pytest.raises(InputError, match=r"corner: must be one of .*bottom-right"):
        tt.locate(tmp_path / "turned.png", folder / "board.toml", corners={"hem-left": pixel})


@pytest.mark.slow
def test_a_sheet_of_paper_is_a_scale(tmp_path: Path) -> None:
    shot = Shot(size=(800, 600), tilt=20.0, distance=1.0, target=(0.28, 0.0), seed=2)
    garment = make_garment("towel", size=SMALL, spacing=0.03)
    cloth = laid(garment.vertices, garment.faces, Pose(0.42, 0.0, 0.0))
    Image.fromarray(photograph(shot, cloth, (Paper(None, size=(0.297, 0.210)),))).save(tmp_path / "sheet.png")
    found = tt.locate(tmp_path / "sheet.png", "a4")
    assert (found.pose.x, found.pose.y) == pytest.approx((0.42, 0.0), abs=0.006)
    assert found.size == pytest.approx(SMALL, rel=0.02)


FRAME = Pose(0.52, 0.42, 0.1)
"""Pose of the fold's frame on the board."""


@pytest.fixture(scope="module")
def fold() -> Fold:
    return make_task("towel", size=(0.24, 0.40), spacing=0.03).fold


def ended(fold: Fold, along: float, across: float, turn: float) -> np.ndarray:
    """The target of a fold whose moved hem lies off it by so much, and turned about its middle."""
    off, _ = fold.crease.split(fold.start)
    share = np.clip(-off / 0.15, 0.0, 1.0)[:, None]
    middle = fold.target[[int(fold.left[0]), int(fold.right[0])], :2].mean(axis=0)
    shift = along * fold.normal + across * fold.crease.along
    moved = Pose(yaw=turn).place(fold.target[:, :2] - middle) + middle + shift
    return np.column_stack([fold.target[:, :2] * (1 - share) + moved * share, fold.target[:, 2]])


def read(fold: Fold, end: np.ndarray, file: Path, given: dict[str, np.ndarray] | None = None) -> FoldReading:
    if not file.exists():
        shot = replace(SHOT, tilt=25.0, distance=0.9, target=(0.44, 0.26))
        Image.fromarray(photograph(shot, laid(end, fold.garment.faces, FRAME), PAPERS)).save(file)
    reader = FoldReader(read_photograph(file, PAGES), FRAME, (0.0005, 0.0005, 0.001), fold)
    return reader.read(given or {})


def test_a_fold_that_ends_short_is_read(fold: Fold, tmp_path: Path) -> None:
    end = ended(fold, -0.020, 0.0, -0.03)
    found = read(fold, end, tmp_path / "short.png")
    true = marks(fold, end)
    for name in ("left_along", "right_along", "slip_along"):
        assert found.values[name][0] == pytest.approx(true[name], abs=0.003), name
    assert all(0.0003 < deviation < 0.006 for _, deviation in found.values.values())
    assert max(draw_reading(found).size) == 1000
    given = {"left": found.corners["left"] + [0.0, 9.0]}
    corrected = read(fold, end, tmp_path / "short.png", given).values
    moved = [corrected[name][0] - found.values[name][0] for name in ("left_along", "left_across")]
    assert np.linalg.norm(moved) > 0.005
    assert corrected["right_along"] == found.values["right_along"]
    with pytest.raises(InputError, match="corner: must be one of left, right, lower-left, lower-right, given 'hem'"):
        read(fold, end, tmp_path / "short.png", {"hem": np.zeros(2)})


@pytest.mark.slow
def test_a_hem_that_covers_the_lower_one_hides_its_slip(fold: Fold, tmp_path: Path) -> None:
    found = read(fold, ended(fold, 0.012, 0.0, 0.0), tmp_path / "beyond.png").values
    assert found["left_along"][0] == pytest.approx(0.012, abs=0.004)
    assert "slip_along" not in found


@pytest.mark.slow
def test_a_fold_that_failed_is_not_read(fold: Fold, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="must show a corner of the moved hem"):
        read(fold, fold.start, tmp_path / "flat.png")


def without(pixels: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The photograph with the table in place of what lies between four places on it."""
    there = SHOT.camera().project(np.column_stack([corners, np.zeros(4)]))
    covered = Image.new("L", (1000, 750))
    ImageDraw.Draw(covered).polygon([(x, y) for x, y in there.tolist()], 255)
    hidden = np.asarray(covered) > 0
    changed = pixels.copy()
    changed[hidden] = pixels[hidden.any(axis=1)][:, 900:].mean(axis=(0, 1))
    return changed


def not_located(words: str, photo: Path, board: Path | str) -> None:
    said = refusal(tt.locate, photo, board)
    assert re.search(words, said) and str(photo) in said


def test_wrong_photographs_are_one_line(tmp_path: Path, folder: Path) -> None:
    board = folder / "board.toml"
    pixels = np.asarray(Image.open(folder / "towel.png"))
    blank = pixels.copy()
    blank[:] = pixels[:60, :60].mean(axis=(0, 1))
    blurred = np.asarray(Image.fromarray(pixels).resize((50, 38)).resize((1000, 750), Image.Resampling.BICUBIC))
    no_towel = without(pixels, PLACE.place(np.array([[-0.17, -0.12], [0.17, -0.12], [0.17, 0.12], [-0.17, 0.12]])))
    other = without(pixels, Board().rim)
    for name, picture, words in (
        ("blank", blank, "board: must be visible"),
        ("blurred", blurred, "too blurred"),
        ("cut", pixels[:, :640], "touches the border|must show the table"),
        ("bare", no_towel, "no garment stands out from the table"),
        ("other", other, "given markers 24 to 47"),
        ("tiny", pixels[::4, ::4], "at least 400 pixels"),
        ("half", pixels[:440, :], "at least .* corners|must be visible"),
    ):
        Image.fromarray(picture).save(tmp_path / f"{name}.png")
        not_located(words, tmp_path / f"{name}.png", board)
    not_located("a white a4 sheet must be visible", tmp_path / "blank.png", "a4")
    (tmp_path / "text.jpg").write_bytes(b"none")
    not_located("must be a picture", tmp_path / "text.jpg", board)
    not_located("cannot be read", tmp_path / "none.jpg", board)


@pytest.mark.slow
def test_cloth_half_of_the_tables_colour_is_refused_if_its_size_is_known(tmp_path: Path, folder: Path) -> None:
    pixels = np.array(Image.open(folder / "towel.png"))
    half = PLACE.place(np.array([[0.07, -0.12], [0.17, -0.12], [0.17, 0.12], [0.07, 0.12]]))
    Image.fromarray(without(pixels, half)).save(tmp_path / "half.png")
    said = r"must measure 0\.200 x 0\.300 m, but measures .* or use a table of another colour"
    with pytest.raises(InputError, match=said):
        tt.locate(tmp_path / "half.png", folder / "board.toml", size=SMALL)


@pytest.mark.slow
def test_photographs_of_any_kind_are_read(tmp_path: Path, folder: Path, located: Located) -> None:
    with Image.open(folder / "towel.png") as image:
        turned = image.transpose(Image.Transpose.ROTATE_90)
        tags = Image.Exif()
        tags[0x0112] = 6  # to be shown turned by a quarter
        turned.convert("RGB").save(tmp_path / "turned.jpg", exif=tags, quality=95)
        image.convert("CMYK").save(tmp_path / "cmyk.tif")
        shifted = (np.asarray(image.convert("L")).astype(np.uint16) << 8) + 128
        Image.fromarray(shifted).save(tmp_path / "grey.png")
    assert read_photograph(tmp_path / "grey.png", PAGES).view.rms < 0.5
    for name in ("turned.jpg", "cmyk.tif"):
        found = tt.locate(tmp_path / name, folder / "board.toml")
        assert found.pose.x == pytest.approx(located.pose.x, abs=0.002), name


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "--board, --sheet: exactly one is needed, given neither"),
        (["--board", "B", "--sheet", "a4"], "--board, --sheet: exactly one is needed, given both"),
        (["--sheet", "a3"], "--sheet: must be a4 or letter, given 'a3'"),
        (["--board", "B", "--board-pose", "1,2"], "board-pose: must be x,y,yaw"),
        (["--board", "B", "--board-pose", "1,2,nan"], "board-pose: must be x,y,yaw"),
        (["--board", "B", "--touch", "0,0 1,0"], "three marks A, B and C"),
        (["--board", "B", "--touch", "0,0 0.3,0 0,0.24"], "mark . is off by"),
        (
            ["--board", "B", "--touch", "0,0 0.18,0 0,0.24", "--board-pose", "0,0,0"],
            "must not both be given; leave one out",
        ),
        (["--board", "B", "--corner", "left"], "--corner: must be NAME=X,Y"),
        (
            ["--board", "B", "--corner", "a=1,2", "--corner", "a=1,2"],
            "--corner: must not name the same corner twice, given a twice",
        ),
        (["--board", "B", "--out", "x.png"], "--out: must be a .json file"),
        (["--board", "B", "--garment", "tshirt"], "must look like a flat tshirt"),
        (["--board", "B", "--picture", "x.svg"], "picture: must be a .png or .jpg"),
        (["--board", "B", "--garment", "sock"], "sock"),
        (["--board", "PHOTO"], "must be a UTF-8 text file"),
    ],
)
def test_wrong_options_are_one_clear_line(options: list[str], words: str, folder: Path) -> None:
    files = {"B": folder / "board.toml", "PHOTO": folder / "towel.png"}
    with pytest.raises(InputError, match=words):
        command("locate", folder / "towel.png", *[files.get(option, option) for option in options])


def test_a_board_prints_at_its_true_size(tmp_path: Path) -> None:
    said = command("board", "--out", tmp_path / "board.pdf")
    assert "150 mm long" in said
    first = (tmp_path / "board.pdf").read_bytes()
    assert first.count(b"/MediaBox [ 0 0 595.27") == 1 and b"Date" not in first
    write_pdf(Board(), tmp_path / "again.pdf")
    assert first == (tmp_path / "again.pdf").read_bytes()
    dark = np.asarray(page(Board(), 0)) < 128
    bar = np.flatnonzero(dark[round((0.012 + 0.240 + 0.009) * DOTS)])
    assert np.ptp(bar) == pytest.approx(0.150 * DOTS, abs=8)
    assert load_board(tmp_path / "board.toml") == Board()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[board]\nbar = 0.02\n", "board.toml: bar"),
        ("[board]\npaper = 'a3'\n", "must be a4 or letter"),
        ("[lens]\n", r"must contain the table \[board\] and nothing else, given lens"),
        ("", "given none"),
    ],
)
def test_a_wrong_board_file_is_one_line(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "board.toml").write_text(text)
    with pytest.raises(InputError, match=words):
        load_board(tmp_path / "board.toml")


def test_a_printer_that_shrinks_is_made_up_for() -> None:
    small = Board(bar=0.1425)
    assert small.size == pytest.approx(0.95 * Board().size)
    assert small.corners == pytest.approx(0.95 * Board().corners)


def views(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Corners of a board as a camera sees them from several sides."""
    seen = []
    for number in range(count):
        shot = Shot(
            tilt=10.0 + 12 * number, azimuth=70.0 * number, distance=0.45, target=(0.09, 0.12), distortion=(0.06, -0.02)
        )
        pixels = shot.camera().project(np.column_stack([Board().corners, np.zeros(35)]))
        seen.append((Board().corners, pixels + np.random.default_rng(number).normal(0.0, 0.05, pixels.shape)))
    return seen


@pytest.fixture(scope="module")
def one_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A photograph of a towel beside a single page of a board."""
    path = tmp_path_factory.mktemp("one") / "page.png"
    Image.fromarray(photograph(SHOT, towel(), PAPERS[:1])).save(path)
    return path


def lens_of(factor: float) -> Lens:
    """The lens of the photographs, with another focal length."""
    return Lens(width=1000, height=750, focal=800 * factor, centre=(499.5, 374.5), distortion=SHOT.distortion)


@pytest.mark.parametrize("factor", [0.8, 1.0, 1.25])
def test_a_lens_of_another_camera_is_refused_or_told(factor: float, folder: Path, one_page: Path) -> None:
    shape = shape_of(make_garment("towel", size=SMALL, spacing=0.03))
    single = locate_shape(read_photograph(one_page, PAGES, lens_of(factor)), shape, learned=True)
    told = [line for line in single.lines() if "does the lens file belong to this camera" in line]
    assert len(told) == (factor != 1.0)
    if factor == 1.0:
        read_photograph(folder / "towel.png", PAGES, lens_of(factor))
    else:
        with pytest.raises(InputError, match=r"lens: must have a focal length of about [78]\d\d pixels"):
            read_photograph(folder / "towel.png", PAGES, lens_of(factor))


def test_a_lens_that_contradicts_the_file_of_the_photo_is_refused(one_page: Path, tmp_path: Path) -> None:
    stated = Image.Exif()
    stated.get_ifd(0x8769)[0xA405] = 28  # a focal length of 28 mm, 809 pixels here
    Image.open(one_page).convert("RGB").save(tmp_path / "a.jpg", quality=95, exif=stated)
    assert read_photograph(tmp_path / "a.jpg", PAGES, lens_of(1.0)).view.lens is not None
    with pytest.raises(InputError, match=r"lens: .* states \(809 pixels\), given 1200"):
        read_photograph(tmp_path / "a.jpg", PAGES, lens_of(1.5))


def test_photos_of_a_board_give_the_lens(tmp_path: Path) -> None:
    lens, rms = calibrate_lens(views(6), (1600, 1200))
    assert lens.focal == pytest.approx(0.8 * 1600, rel=0.003)
    assert lens.distortion[0] == pytest.approx(0.06, abs=0.01)
    assert rms < 0.1
    write_lens(lens, tmp_path / "lens.toml")
    assert load_lens(tmp_path / "lens.toml") == lens
    assert scaled(lens, (800, 600)).focal == pytest.approx(lens.focal / 2)
    with pytest.raises(
        InputError, match=r"lens: must have the aspect ratio of the photo \(1000 x 1000 pixels\), given 1600 x 1200"
    ):
        scaled(lens, (1000, 1000))
    with pytest.raises(InputError, match="at angles that differ by at least 20 degrees, given 0"):
        calibrate_lens(views(1) * 6, (1600, 1200))
    with pytest.raises(InputError, match="at least 4"):
        calibrate_lens(views(2), (1600, 1200))


def test_a_board_that_is_not_flat_is_refused() -> None:
    points, pixels = views(2)[1]
    bent = pixels + 80.0 * np.outer((points[:, 0] / 0.18) ** 2, [0.0, 1.0])
    with pytest.raises(InputError, match="lay the board flat"):
        estimate([(points, bent)], (1600, 1200))


@pytest.mark.parametrize("change", [{"focal": 0.01}, {"focal": 1e6}, {"centre": (-5000.0, 9e9)}])
def test_a_lens_with_which_no_board_is_flat_is_named(change: dict[str, object]) -> None:
    lens = Lens(width=1600, height=1200, focal=1280.0, centre=(799.5, 599.5)).model_copy(update=change)
    with pytest.raises(InputError, match="lay the board flat and leave --lens out"):
        estimate([views(2)[1]], (1600, 1200), lens)


def test_a_camera_finds_places_again() -> None:
    camera = SHOT.camera()
    places = np.array([[0.1, 0.2], [0.8, -0.1]])
    assert camera.on_table(camera.project(np.column_stack([places, [0.01, 0.01]])), 0.01) == pytest.approx(places)
    with pytest.raises(
        InputError, match="must be taken from higher up, because the cloth reaches the horizon; tilt the camera down"
    ):
        Shot(tilt=85.0).camera().on_table(np.array([[800.0, 0.0]]))


def test_corners_of_a_board_are_found_to_hundredths_of_a_pixel() -> None:
    """Each is the saddle of a black and white cross that is turned, blurred and noisy."""
    errors = []
    for seed in range(10):
        generator = np.random.default_rng(seed)
        true = np.array([[20.0 * column, 20.0 * row] for row in (1, 2, 3) for column in (1, 2, 3)])
        true += generator.uniform(-0.5, 0.5, true.shape)
        y, x = np.mgrid[0:80, 0:80].astype(float)
        grey = np.full(x.shape, 128.0)
        for cx, cy in true:
            near = np.hypot(x - cx, y - cy) < 9.0
            u, v = 0.95 * (x - cx) + 0.3 * (y - cy), -0.3 * (x - cx) + 0.95 * (y - cy)
            grey[near] += (90.0 * np.tanh(u) * np.tanh(v))[near]
        seen = np.clip(grey + generator.normal(0.0, 2.0, grey.shape), 0, 255).astype(np.uint8)
        errors.append(saddles(seen, true + generator.uniform(-0.8, 0.8, true.shape)) - true)
    assert np.sqrt(np.square(errors).mean()) < 0.03


def test_an_outline_is_the_lower_edge_before_the_camera_and_the_upper_one_behind() -> None:
    camera = Shot(tilt=40.0, distance=1.2).camera()
    square = np.array([[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]])
    places = shapely.LinearRing(square).segmentize(0.01)
    points = np.array(places.coords)[:-1]
    lengths = np.abs(np.diff(np.vstack([points, points[:1]]), axis=0)).max()
    assert lengths <= 0.0101
    heights = np.where(points[:, 1] < -0.099, 0.0, np.where(points[:, 1] > 0.099, 0.004, 0.002))
    found = camera.on_rim(camera.project(np.column_stack([points, heights])), 0.004)
    sides = np.abs(points[:, 0]) < 0.07  # away from the corners
    assert np.abs(found - points)[sides, 1].max() < 0.0011
    flat = camera.on_table(camera.project(np.column_stack([points, heights])), 0.002)
    assert np.abs(flat - points)[sides, 1].max() > 0.0015


def test_marks_that_are_touched_give_the_boards_pose() -> None:
    pose = Pose(0.4, 0.1, 1.2)
    assert touched_pose(Board().marks, pose.place(Board().marks)).yaw == pytest.approx(1.2)
    assert parse_touched("0,0,1 1,0,1 0,1,1").shape == (3, 3)
    assert parse_pose("0.1,0.2,0.3", "board-pose") == Pose(0.1, 0.2, 0.3)
    with pytest.raises(InputError, match="heights of the marks must differ by at most 10 mm, given 20 mm"):
        touched_pose(Board().marks, np.column_stack([Board().marks, [0.0, 0.0, 0.02]]))


@pytest.mark.parametrize("name", [pytest.param("tshirt", marks=pytest.mark.slow), "trousers"])
def test_other_garments_are_laid_over_their_outlines(name: str) -> None:
    shape = shape_of(make_garment(name, spacing=0.04))
    for pose in (Pose(0.3, 0.2, 2.5), Pose(-0.1, 0.0, -1.0)):
        found = pose.place(shape.points * [1.04, 0.97])[::4]
        fit = lay(shape, found, {})
        assert (fit.pose.x, fit.pose.y, fit.pose.yaw) == pytest.approx((pose.x, pose.y, pose.yaw), abs=0.002)
        assert fit.scale == pytest.approx([1.04, 0.97], abs=0.003)


def test_a_line_ignores_what_lies_elsewhere() -> None:
    at = np.linspace(0.0, 1.0, 50)
    points = np.column_stack([at, 0.5 * at + 0.1])
    points[:8] += [0.0, 0.2]
    line = Line.through(points)
    assert abs(line.direction[1] / line.direction[0]) == pytest.approx(0.5, abs=1e-3)
    assert line.meets(Line.through(np.array([[0.5, 0.0], [0.5, 1.0], [0.5, 2.0]]))) == pytest.approx(
        [0.5, 0.35], abs=1e-3
    )


def test_the_photographs_scale_is_that_of_the_table(folder: Path) -> None:
    photo = read_photograph(folder / "towel.png", PAGES)
    assert photo.resolution(np.zeros((1, 2))) == pytest.approx(0.0014, abs=0.0004)
