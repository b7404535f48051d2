"""Other people's files, read as they were meant: lines around a piece, marks, squeezed UV maps, rounded vertices."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh
from PIL import Image

from tatamu.base.errors import InputError
from tatamu.garments import Garment, make_garment
from tatamu.garments.meshfile import welded
from tatamu.garments.objfile import TriangleMesh, parse_obj
from tatamu.simulation.mesh.topology import areas
from tests.commands import command
from tests.foreign import svg
from tests.photos import SHIRT, overlap

PIECE = np.array([[60, 20], [360, 20], [400, 120], [360, 470], [60, 470], [20, 120]], dtype=float)
"""A bag, as it is sewn [mm]."""


def drawn(points: np.ndarray) -> str:
    return "M " + " L ".join(f"{x:.3f},{y:.3f}" for x, y in points) + " Z "


def wider(by: float) -> np.ndarray:
    return np.array(shapely.Polygon(PIECE).buffer(by, join_style="mitre").exterior.coords[:-1])


def garment(folder: Path, body: str, *lines: str, spacing: float = 0.03) -> Garment:
    """The garment of an SVG with these lines in its garment file."""
    (folder / "a.svg").write_text(svg(body, 420, 490))
    (folder / "a.toml").write_text("\n".join(["[garment]", 'outline = "a.svg"', f"spacing = {spacing}", *lines]))
    return make_garment(str(folder / "a.toml"))


def cloth_area(made: Garment) -> float:
    return float(areas(made.unstrained, made.faces).sum())


SEWN = shapely.Polygon(PIECE * 1e-3).area
LINES = {
    "two paths": f'<path d="{drawn(wider(10))}"/><path d="{drawn(PIECE)}"/>',
    "sewn line first": f'<path d="{drawn(PIECE)}"/><path d="{drawn(wider(10))}"/>',
    "one path": f'<path d="{drawn(wider(10))}{drawn(PIECE[::-1])}"/>',
    "a wide hem": f'<path d="{drawn(np.maximum(wider(10), [0, 10]) + np.where(wider(10) > 470, [0, 30], 0))}"/>'
    f'<path d="{drawn(PIECE)}"/>',
    "a topstitch within": f'<path d="{drawn(wider(10))}"/><path d="{drawn(PIECE)}"/><path d="{drawn(wider(-6))}"/>',
}


@pytest.mark.parametrize("kind", LINES)
def test_a_line_around_the_sewn_line_is_a_seam_allowance_and_no_ring(kind: str, tmp_path: Path) -> None:
    made = garment(tmp_path, LINES[kind])
    assert made.size == pytest.approx((0.38, 0.45), abs=1e-4)
    assert cloth_area(made) == pytest.approx(SEWN, rel=2e-3)
    assert any("the inner outline is taken as the seam" in note for note in made.notes)
    assert not any(name.startswith("hole") for name in made.edges)


def test_a_ring_is_had_for_the_asking(tmp_path: Path) -> None:
    ring = f'<path d="{drawn(wider(40))}"/><path d="{drawn(PIECE)}"/>'
    made = garment(tmp_path, ring, "holes = true", spacing=0.02)
    assert cloth_area(made) == pytest.approx(shapely.Polygon(wider(40) * 1e-3).area - SEWN, rel=0.01)
    assert any(note.startswith("closed curves inside the outline become 1 hole of 0.15") for note in made.notes)


def test_holes_are_told_with_their_number_and_area(tmp_path: Path) -> None:
    holes = '<rect x="100" y="100" width="100" height="80"/><rect x="250" y="100" width="60" height="100"/>'
    made = garment(tmp_path, f'<path d="{drawn(PIECE)}"/>{holes}')
    assert any(
        note.startswith("closed curves inside the outline become 2 holes of 0.0140 m2 in all") for note in made.notes
    )
    assert cloth_area(made) == pytest.approx(SEWN - 0.014, rel=5e-3)
    whole = garment(tmp_path, f'<path d="{drawn(PIECE)}"/>{holes}', "holes = false")
    assert cloth_area(whole) == pytest.approx(SEWN, rel=2e-3)
    left_out = "are left out, because holes = false: 2 closed curves of 0.0140 m2 in all"
    assert any(left_out in note for note in whole.notes)


MARKS = {
    "button": '<circle cx="200" cy="200" r="1.5"/>',
    "drill hole": '<circle cx="200" cy="200" r="0.2"/>',
    "letter": '<path d="M 150 200 v 40 h 5 v -15 h 15 v 15 h 5 v -40 h -5 v 20 h -15 v -20 Z"/>',
    "word": '<path d="M 100 100 h 9 v 9 h -9 Z M 105 102 h 9 v 9 h -9 Z M 200 100 h 3 v 3 h -3 Z"/>',
    "notch across": '<path d="M 195 15 h 10 l -5 12 Z"/>',
}


@pytest.mark.parametrize("mark", MARKS)
def test_marks_smaller_than_a_cell_are_left_out_with_a_note(mark: str, tmp_path: Path) -> None:
    made = garment(tmp_path, f'<path d="{drawn(PIECE)}"/>{MARKS[mark]}')
    assert cloth_area(made) == pytest.approx(SEWN, rel=2e-3)
    assert any("closed curve" in note and "left out" in note for note in made.notes)


def test_holes_that_overlap_are_one(tmp_path: Path) -> None:
    holes = '<rect x="100" y="100" width="100" height="100"/><rect x="150" y="150" width="100" height="100"/>'
    made = garment(tmp_path, f'<path d="{drawn(PIECE)}"/>{holes}')
    assert cloth_area(made) == pytest.approx(SEWN - 0.0175, rel=5e-3)


def test_a_piece_in_centimetres_under_a_header_of_millimetres_is_doubted(tmp_path: Path) -> None:
    import ezdxf

    document = ezdxf.new()  # type: ignore[attr-defined]
    document.units = 4
    document.modelspace().add_lwpolyline(0.1 * SHIRT * [1, 1.5], close=True)
    document.saveas(tmp_path / "a.dxf")
    made = make_garment(str(tmp_path / "a.dxf"))
    assert made.size == pytest.approx((0.054, 0.069))
    assert any("is the file in centimetres?" in note and "--scale 0.01" in note for note in made.notes)
    asked = make_garment(str(tmp_path / "a.dxf"), scale=0.001)
    assert not any("is the file in" in note for note in asked.notes)


# meshes


def tube(path: Path, squeezed: tuple[float, float], around: int = 48, along: int = 24) -> Path:
    """A tube of elliptic section, 0.6 m around and 0.4 m long, with a UV map of two panels, squeezed along u and v."""
    angle = np.linspace(0.0, 2.0 * np.pi, 4001)
    section = np.column_stack([np.cos(angle), 0.6 * np.sin(angle)])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(section, axis=0), axis=1))])
    at = np.interp(np.arange(around) / around * arc[-1], arc, angle)
    ring = 0.6 / arc[-1] * np.column_stack([np.cos(at), 0.6 * np.sin(at)])
    half, step = around // 2, 0.6 / around
    lines = [f"v {x:.9f} {h:.9f} {z:.9f}" for h in np.linspace(0, 0.4, along + 1) for x, z in ring]
    for start in (0.0, 0.4):
        rows = [(start + k * step, h) for h in np.linspace(0, 0.4, along + 1) for k in range(half + 1)]
        lines += [f"vt {u * squeezed[0]:.9f} {v * squeezed[1]:.9f}" for u, v in rows]
    for row in range(along):
        for k in range(around):
            first = 1 + (k // half) * (along + 1) * (half + 1) + row * (half + 1) + k % half
            image = [first, first + half + 1, first + half + 2, first + 1]
            corner = [1 + row * around + k, 1 + (row + 1) * around + k]
            corner += [1 + (row + 1) * around + (k + 1) % around, 1 + row * around + (k + 1) % around]
            lines.append("f " + " ".join(f"{place}/{shown}" for place, shown in zip(corner, image, strict=True)))
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize("squeezed", [(1.0, 1.0), (1.0, 1.1), (0.8, 1.0), (3.0, 4.5)])
def test_a_uv_map_that_is_not_square_is_set_right(squeezed: tuple[float, float], tmp_path: Path) -> None:
    made = make_garment(str(tube(tmp_path / "tube.obj", squeezed)))
    assert made.size == pytest.approx((0.3, 0.4), rel=2e-3)
    told = [note for note in made.notes if "misses the mesh by" in note]
    assert bool(told) == (squeezed[0] != squeezed[1])
    for note in told:
        u, v = (1.0 + 0.01 * float(part) for part in re.findall(r"([+-][0-9.]+) %", note))
        assert v / u == pytest.approx(squeezed[1] / squeezed[0], rel=2e-3)


@pytest.mark.parametrize("noise", [1e-8, 1e-7])
def test_vertices_on_both_sides_of_a_rounding_limit_are_one(noise: float) -> None:
    from tatamu.simulation.mesh.meshing import staggered_rectangle

    vertices, faces = staggered_rectangle(0.3, 0.4, 0.02)
    random = np.random.default_rng(0)
    soup = vertices[faces.ravel()] + random.uniform(-noise, noise, (faces.size, 3))
    mesh = welded(TriangleMesh(soup, np.arange(faces.size).reshape(-1, 3)))
    assert len(mesh.vertices) == len(vertices)
    assert len(mesh.faces) == len(faces)


@pytest.mark.parametrize("turn", [0, 5])
@pytest.mark.parametrize("front", [1, -1])
def test_a_concave_face_stays_within_its_outline(turn: int, front: int, tmp_path: Path) -> None:
    corners = np.roll(SHIRT, turn, axis=0)[::front] * 1e-3
    lines = [f"v {x:.6f} {y:.6f} {0.3 * x:.6f}" for x, y in corners]
    (tmp_path / "a.obj").write_text("\n".join([*lines, "f " + " ".join(map(str, range(1, len(corners) + 1)))]))
    mesh = parse_obj((tmp_path / "a.obj").read_bytes())
    assert len(mesh.faces) == len(corners) - 2
    flat = mesh.vertices[:, :2]
    assert shapely.union_all(shapely.polygons(flat[mesh.faces])).area == pytest.approx(shapely.Polygon(corners).area)
    a, b, c = (flat[mesh.faces[:, k]] for k in range(3))
    turns = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert (np.sign(turns) == np.sign(turns[0])).all()
    assert turns[0] > 0 if shapely.is_ccw(shapely.LinearRing(corners)) else turns[0] < 0


def test_a_convex_face_is_a_fan_as_before(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    assert parse_obj((tmp_path / "a.obj").read_bytes()).faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_a_mesh_of_trimesh_in_any_format_is_the_same(tmp_path: Path) -> None:
    from tatamu.garments.meshfile import read_mesh

    box = trimesh.creation.box((0.3, 0.4, 0.5))
    for kind in ("ply", "stl", "glb", "obj"):
        box.export(tmp_path / f"box.{kind}")
        mesh = read_mesh(tmp_path / f"box.{kind}")
        assert areas(mesh.vertices, mesh.faces).sum() == pytest.approx(box.area)
        assert len(welded(mesh).vertices) == 8


# photos


def picture(path: Path, colours: dict[str, tuple[int, int, int]], alpha: bool = False) -> np.ndarray:
    """A shirt 1.5 pixels per millimetre with a stripe; its true outline [pixels]."""
    truth = SHIRT * 1.5 + 95
    y, x = np.mgrid[0:880, 0:1000]
    inside = shapely.contains_xy(shapely.Polygon(truth), x, y)
    stripe = inside & (y > 480) & (y < 640)
    pixels = np.empty((880, 1000, 4), dtype=np.uint8)
    pixels[..., :3], pixels[..., 3] = colours["table"], 255
    pixels[inside, :3], pixels[stripe, :3] = colours["shirt"], colours["stripe"]
    noise = np.random.default_rng(0).integers(-4, 5, pixels.shape[:2])
    pixels[..., :3] = np.clip(pixels[..., :3].astype(int) + noise[..., None], 0, 255)
    if alpha:
        pixels[~inside, 3] = 0
    Image.fromarray(pixels if alpha else pixels[..., :3]).save(path)
    return np.asarray(truth)


TABLE, NAVY = (236, 236, 230), (26, 34, 78)


def test_the_alpha_channel_is_the_mask(tmp_path: Path) -> None:
    from tatamu.garments.photo import find_outline

    truth = picture(tmp_path / "a.png", {"table": NAVY, "shirt": NAVY, "stripe": TABLE}, alpha=True)
    found = find_outline(tmp_path / "a.png")
    assert overlap(found.outline, truth) > 0.995
    assert "alpha channel" in found.notes[0]
    x0, y0 = np.floor(truth.min(axis=0)).astype(int)
    x1, y1 = np.ceil(truth.max(axis=0)).astype(int)
    Image.open(tmp_path / "a.png").crop((x0, y0, x1, y1)).save(tmp_path / "cropped.png")
    assert overlap(find_outline(tmp_path / "cropped.png").outline, truth - [x0, y0]) > 0.995


def test_an_alpha_channel_that_cuts_nothing_out_is_passed_over(tmp_path: Path) -> None:
    from tatamu.garments.photo import find_outline

    truth = picture(tmp_path / "a.png", {"table": TABLE, "shirt": NAVY, "stripe": NAVY})
    image = Image.open(tmp_path / "a.png").convert("RGBA")
    for corner in ((0, 0), (999, 0), (0, 879), (999, 879)):  # rounded, as in a picture of a screen
        image.putpixel(corner, (0, 0, 0, 0))
    image.save(tmp_path / "a.png")
    found = find_outline(tmp_path / "a.png")
    assert overlap(found.outline, truth) > 0.99
    assert found.notes == ()


def test_other_regions_that_stand_out_are_told_and_can_be_joined(tmp_path: Path) -> None:
    truth = picture(tmp_path / "a.png", {"table": TABLE, "shirt": NAVY, "stripe": TABLE})
    given = ("outline", tmp_path / "a.png", "--width", 0.54, "--out", tmp_path / "a.svg")
    said = command(*given)
    assert "note: 1 other region stands out" in said and "--join" in said
    assert "note" not in command(*given, "--join")
    size = np.ptp(truth, axis=0) / np.ptp(truth[:, 0]) * 0.54
    assert make_garment(str(tmp_path / "a.svg"), spacing=0.03).size == pytest.approx(tuple(size), abs=3e-3)


def test_the_sheet_that_gives_the_scale_is_no_part_of_the_garment(tmp_path: Path) -> None:
    picture(tmp_path / "a.png", {"table": (150, 110, 75), "shirt": NAVY, "stripe": NAVY})
    image = Image.open(tmp_path / "a.png")
    image.paste((250, 250, 250), (60, 640, 200, 840))
    image.save(tmp_path / "a.png")
    out = ("--out", tmp_path / "a.svg")
    sheet = ("--sheet", "60,640 200,640 200,840 60,840 0.0933x0.1333")
    assert "other region" in command("outline", tmp_path / "a.png", "--width", 0.54, *out)
    assert "other region" not in command("outline", tmp_path / "a.png", *sheet, *out)
    with pytest.raises(InputError, match="must be pixels X,Y from"):
        command("outline", tmp_path / "a.png", "--ruler", "1e308,0 -1e308,0 1", *out)
