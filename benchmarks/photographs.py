"""How well photographs tell where cloth lies and how folds ended: rendered photos, whose truth is known.

    python -m benchmarks.photographs [--only locate|fold] [--write-docs]     docs/notes/photographs.md; minutes

Photos have 1600 x 1200 pixels, a lens with distortion, uneven light, shadow, wood grain and noise. The same photo is
read with both pages of its board, with the first page and the lens, with the first page alone, and with a sheet.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import shapely
from PIL import Image
from tests.photographs import BLUE, WOOD, Cloth, Paper, Shot, laid, photograph

from benchmarks.tables import IMAGES, arguments, show
from tatamu.base.errors import InputError
from tatamu.cameras.board import Board, page
from tatamu.cameras.camera import estimate
from tatamu.cameras.lens import Lens
from tatamu.cameras.locate import Located, locate_shape
from tatamu.cameras.markers import find_pages
from tatamu.cameras.photograph import Photograph, load_scale, read_photograph
from tatamu.cameras.pictures import draw_located, draw_reading
from tatamu.cameras.pose import Pose, wrapped
from tatamu.cameras.reading import FoldReader, FoldReading
from tatamu.cameras.shape import shape_of
from tatamu.evaluation.nominal import Nominal
from tatamu.folding.fold import Fold
from tatamu.folding.score import MARKS, marks
from tatamu.folding.task import Task, make_task
from tatamu.garments import Garment, make_garment

BOARD = Board(pages=2)
PIXELS = (1600, 1200)
"""Width and height of photos."""
FOLD_PIXELS = (1200, 900)
"""Width and height of photos of folds, which are taken from nearer."""
SHEET = Pose(0.10, 0.62, 0.15)
SIZE = (0.34, 0.60)
"""Width and length of the towel [m]."""
LENS = (0.03, -0.012)
"""k1 and k2 of the camera."""
KNOWN = Lens(
    width=PIXELS[0], height=PIXELS[1], focal=1.003 * 0.8 * PIXELS[0], centre=(800.0, 600.0), distortion=(0.031, -0.012)
)
"""The lens as its file has it: the focal length is 0.3 % off, because focusing changes it."""
TILTS = (0.0, 20.0, 40.0)
SCALES = ("two pages", "one page, lens known", "one page", "sheet of paper")
SEEDS = (1,)
FOLDS = 8
"""Number of folds that are simulated and read."""


@dataclass(frozen=True)
class Look:
    """The appearance of cloth and light."""

    name: str
    shot: dict[str, Any]
    colour: tuple[int, int, int] = BLUE


def mixed(share: float) -> tuple[int, int, int]:
    """A colour between the table's (0) and blue (1)."""
    red, green, blue = (round(w + share * (b - w)) for w, b in zip(WOOD, BLUE, strict=True))
    return red, green, blue


LOOKS = (
    Look("high light", {}),
    Look("low sun, more noise", {"sun": (-0.9, 0.5, 0.6), "noise": 6.0, "blur": 0.8}),
    Look("half the contrast", {}, mixed(0.5)),
)


@dataclass(frozen=True)
class Found:
    """The errors of one reading."""

    scale: str
    tilt: float
    look: str
    garment: str
    outline: np.ndarray
    """Distances of the outline that was found from the true one [m]."""
    off: np.ndarray
    """Errors of x, y [m] and yaw [rad]."""
    stated: np.ndarray
    """Standard deviations of x, y [m] and yaw [rad]."""


def scene(garment: Garment, tilt: float, look: Look, seed: int) -> tuple[Shot, Cloth, Pose, tuple[Paper, ...]]:
    """A photograph to take: the cloth in the middle of two pages and a sheet."""
    random = np.random.default_rng([seed, round(tilt)])
    pose = Pose(0.62 + random.uniform(-0.04, 0.04), 0.40 + random.uniform(-0.04, 0.04), random.uniform(-0.3, 0.3))
    shot = Shot(
        size=PIXELS, tilt=tilt, azimuth=-90.0 + random.uniform(-30, 30), roll=random.uniform(-8, 8), distance=1.75,
        target=(0.55, 0.36), distortion=LENS, seed=seed, **look.shot,
    )  # fmt: skip
    papers = (
        Paper(BOARD),
        Paper(BOARD, 1, Pose(1.02, 0.10, random.uniform(-0.2, 0.2))),
        Paper(None, pose=SHEET, size=(0.297, 0.210)),
    )
    return shot, laid(garment.vertices, garment.faces, pose, colour=look.colour), pose, papers


def photographs(path: Path) -> Iterator[tuple[str, Photograph, Pose]]:
    """The same photograph with each scale, and the pose of its frame on the first page's."""
    both = read_photograph(path, BOARD)
    seen = find_pages(np.asarray(Image.open(path).convert("L")), BOARD)
    size = both.view.size
    yield "two pages", both, Pose()
    yield "one page, lens known", replace(both, view=estimate(seen[:1], size, KNOWN)), Pose()
    yield "one page", replace(both, view=estimate(seen[:1], size)), Pose()
    try:
        sheet = read_photograph(path, load_scale("a4"))
    except InputError as error:
        print(f"  sheet: {error}")
        return
    papers = (*sheet.papers, *(pixels_on(sheet, both, paper) for paper in both.papers))
    yield "sheet of paper", replace(sheet, papers=papers), SHEET


def pixels_on(sheet: Photograph, both: Photograph, paper: np.ndarray) -> np.ndarray:
    """A paper in the frame of another photograph."""
    return sheet.view.camera.on_table(both.in_pixels(paper))


def errors(located: Located, true: Pose, frame: Pose, garment: Garment) -> tuple[np.ndarray, np.ndarray]:
    """Distances of the outline, and errors of x, y and yaw, in the first page's frame."""
    pose = located.pose.within(frame)
    own = true.seen_from(frame.place(located.outline))
    away = shapely.distance(shape_of(garment).polygon.exterior, shapely.points(own))
    return away, np.array([pose.x - true.x, pose.y - true.y, wrapped(pose.yaw - true.yaw)])


def located(folder: Path) -> list[Found]:
    """Read all photographs."""
    found = []
    towel = make_garment("towel", size=SIZE, spacing=0.03)
    cases = [(towel, tilt, look, seed) for tilt in TILTS for look in LOOKS for seed in SEEDS]
    cases += [
        (make_garment(name, spacing=0.03), tilt, LOOKS[0], 3) for name in ("tshirt", "trousers") for tilt in TILTS[1:2]
    ]
    for garment, tilt, look, seed in cases:
        shot, cloth, pose, papers = scene(garment, tilt, look, seed)
        path = folder / "photo.png"
        Image.fromarray(photograph(shot, cloth, papers)).save(path)
        for scale, photo, frame in photographs(path):
            try:
                one = locate_shape(photo, shape_of(garment), learned=True)
            except InputError as error:
                print(f"  {garment.name}, {tilt:.0f} degrees, {look.name}, {scale}: {error}")
                continue
            away, off = errors(one, pose, frame, garment)
            found.append(Found(scale, tilt, look.name, garment.name, away, off, np.array(one.deviation)))
            print(
                f"{garment.name}, {tilt:.0f} degrees, {look.name}, {scale}: {1e3 * np.hypot(*off[:2]):.1f} mm",
                flush=True,
            )
    return found


def row(found: list[Found], **names: str) -> dict[str, str]:
    """Return one row of the table."""
    outline = np.concatenate([one.outline for one in found])
    place = [float(np.hypot(*one.off[:2])) for one in found]
    stated = [float(np.hypot(*one.stated[:2])) for one in found]
    inside = [np.abs(one.off) <= 2.0 * one.stated for one in found]
    return {
        **names,
        "photos": str(len(found)),
        "outline, 95 % [mm]": f"{1e3 * np.percentile(outline, 95):.1f}",
        "outline, worst [mm]": f"{1e3 * outline.max():.1f}",
        "place, median [mm]": f"{1e3 * np.median(place):.1f}",
        "place, worst [mm]": f"{1e3 * max(place):.1f}",
        "stated [mm]": f"{1e3 * np.median(stated):.1f}",
        "yaw, worst [deg]": f"{np.degrees(max(abs(one.off[2]) for one in found)):.2f}",
        "within two deviations": f"{100 * np.mean(inside):.0f} %",
    }


def by_scale(found: list[Found]) -> list[dict[str, str]]:
    """Rows of towels for each scale and tilt."""
    chosen = [(scale, tilt) for scale in SCALES for tilt in TILTS]
    groups = {key: [f for f in found if (f.scale, f.tilt) == key and f.garment == "towel"] for key in chosen}
    return [row(group, scale=scale, tilt=f"{tilt:.0f}°") for (scale, tilt), group in groups.items() if group]


def by_look(found: list[Found]) -> list[dict[str, str]]:
    """Rows for each look and garment, with two pages."""
    best = [one for one in found if one.scale == SCALES[0]]
    keys = list(dict.fromkeys((one.garment, one.look) for one in best))
    return [
        row([one for one in best if (one.garment, one.look) == (garment, look)], garment=garment, photo=look)
        for garment, look in keys
    ]


def outcomes(task: Task) -> Iterator[np.ndarray]:
    """Ends of folds whose parameters are somewhat off the middle of their ranges [m], shape (n, 3)."""
    random = np.random.default_rng(7)
    evaluator = Nominal(task)
    middle = task.space.middle()
    for _ in range(FOLDS):
        moved = {
            name: value if isinstance(value, int) else value * float(random.uniform(0.7, 1.3))
            for name, value in middle.items()
        }
        rollout = evaluator(moved).rollout
        if rollout is not None:
            yield rollout.positions[-1] + np.array([*random.normal(0.0, 0.003, 2), 0.0])


class Setting:
    """A table, boards and a camera, and a photograph of the cloth before the fold, which gives its frame."""

    def __init__(self, fold: Fold, seed: int) -> None:
        self._fold, garment = fold, fold.garment
        shot, _, self._pose, self._papers = scene(garment, 25.0, LOOKS[0], seed)
        self._shot = replace(shot, size=FOLD_PIXELS, distance=1.5)
        self.before = locate_shape(self._photo(fold.start, seed), shape_of(garment), learned=True)

    def _photo(self, points: np.ndarray, seed: int) -> Photograph:
        cloth = laid(points, self._fold.garment.faces, self._pose)
        with TemporaryDirectory() as folder:
            path = Path(folder) / "photo.png"
            Image.fromarray(photograph(replace(self._shot, seed=seed), cloth, self._papers)).save(path)
            return read_photograph(path, BOARD)

    def read(self, final: np.ndarray, seed: int) -> FoldReading:
        """Photograph a finished fold [m], shape (n, 3), and read it."""
        photo = self._photo(final, seed)
        return FoldReader(photo, self.before.pose, self.before.deviation, self._fold).read({})


def folds(folder: Path) -> list[dict[str, str]]:
    """Rows of what is read of simulated folds: before and after are photographs."""
    task = make_task("towel", size=(0.30, 0.50), spacing=0.025)
    setting = Setting(task.fold, 5)
    draw_located(setting.before).save(folder / "located.png")
    read: dict[str, list[tuple[float, float]]] = {}
    count = 0
    for final in outcomes(task):
        count += 1
        true = marks(task.fold, final)
        try:
            reading = setting.read(final, count)
        except InputError as error:
            print(f"  fold {count}: {error}")
            continue
        draw_reading(reading).save(folder / f"fold-{count}.png")
        for name, value in true.items():
            pair = reading.values.get(name)
            words = f"{1e3 * pair[0]:.1f} +- {1e3 * pair[1]:.1f} mm" if pair else "nothing"
            print(f"fold {count}, {name}: {1e3 * value:.1f} mm, read {words}", flush=True)
            if pair:
                read.setdefault(name, []).append((pair[0] - value, pair[1]))
    rows = []
    for name in MARKS:
        pairs = np.array(read.get(name, [])).reshape(-1, 2)
        seen = len(pairs)
        rows.append(
            {
                "measured": name,
                "seen": f"{seen} of {count}",
                "error, median [mm]": f"{1e3 * np.median(np.abs(pairs[:, 0])):.1f}" if seen else "",
                "error, worst [mm]": f"{1e3 * np.abs(pairs[:, 0]).max():.1f}" if seen else "",
                "stated [mm]": f"{1e3 * np.median(pairs[:, 1]):.1f}" if seen else "",
                "within two deviations": f"{100 * np.mean(np.abs(pairs[:, 0]) <= 2 * pairs[:, 1]):.0f} %"
                if seen
                else "",
            }
        )
    return rows


def pictures(folder: Path) -> None:
    """Put the pictures of the guide into the docs: those of the first fold, and a page of the board."""
    for source, name in (("located", "photograph-located"), ("fold-1", "photograph-fold-read")):
        with Image.open(folder / f"{source}.png") as drawn:
            drawn.thumbnail((900, 900), Image.Resampling.LANCZOS)
            drawn.convert("RGB").save(IMAGES / f"{name}.jpg", quality=85)
    small = page(BOARD, 0).resize((420, 594), Image.Resampling.LANCZOS)
    small.quantize(8).save(IMAGES / "board.png", optimize=True)


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--only", choices=("locate", "fold"), help="a part of it")
    parser.add_argument("--out", type=Path, help="folder that keeps photos and drawings; default: none are kept")
    options = parser.parse_args()
    with TemporaryDirectory() as temporary:
        folder = options.out or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        tables: dict[str, list[dict[str, str]]] = {}
        if options.only in (None, "locate"):
            found = located(folder)
            tables |= {"photographs: scale": by_scale(found), "photographs: look": by_look(found)}
        if options.only in (None, "fold"):
            tables |= {"photographs: folds": folds(folder)}
            if options.write_docs:
                pictures(folder)
    show(tables, options.write_docs)


if __name__ == "__main__":
    main()
