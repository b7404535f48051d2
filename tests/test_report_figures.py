"""Figures of the report: histograms, replay, paths, maps, pictures."""

from __future__ import annotations

import base64
import sys
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tatamu.report import picture
from tatamu.report.errormap import largest, maps
from tatamu.report.histogram import bin_width, histogram
from tatamu.report.page import replay
from tatamu.report.paths import plot
from tatamu.show.raster import View, rasterise, vertex_normals
from tatamu.show.replay import FRAMES, frames, motion
from tatamu.show.solids import tube
from tatamu.study.result import Result
from tests.fabricated import changed, grid, report, rewritten, write_fold
from tests.pages import shown, unpacked


@pytest.mark.parametrize(
    ("count", "gone", "titles"),
    [
        (50, [], ["First trial", "Best after 10", "Best after 50"]),
        (60, [], ["First trial", "Best after 10", "Best after 50", "Best of all 60"]),
        (20, ["error_50"], ["First trial", "Best after 10", "Best of all 20"]),
        (1, ["error_10", "error_50"], ["First trial"]),
    ],
)
def test_histograms_follow_the_search(tmp_path: Path, count: int, gone: list[str], titles: list[str]) -> None:
    folder = write_fold(tmp_path / "towel", spacing=0.08, frames=6, count=count)
    rewritten(folder, lambda a: [a.pop(name) for name in gone])
    assert [title for title, _ in Result.load(folder).moments] == titles
    report(folder)


def test_a_histogram_counts_every_vertex() -> None:
    errors = np.array([0.0, 0.0011, 0.0012, 0.0100])
    bars = histogram(errors, 0.001)["data"][0]
    assert sum(bars["y"]) == 4
    assert dict(zip(bars["x"], bars["y"], strict=True))[1.5] == 2
    assert bars["x"][-1] > 10.0 > bars["x"][-2]


def test_packed_motion_comes_back_whole() -> None:
    steps = np.random.default_rng(0).integers(0, 65536, size=(7, 5, 3))
    steps[0, 0], steps[1, 0], steps[2, 0] = 0, 65535, 0
    assert (unpacked(motion(steps), steps.shape) == steps).all()


def test_the_replay_holds_the_cloth_to_a_tenth_of_a_millimetre(folder: Path) -> None:
    fold = Result.load(folder)
    data = replay(fold, 0.005)
    places = shown(data)
    assert places.shape == (25, len(fold.start), 3)
    assert np.abs(places[:-1] - fold.rollout.positions).max() < 2.6e-5
    assert np.abs(places[-1] - fold.target).max() < 2.6e-5
    faces = np.frombuffer(zlib.decompress(base64.b64decode(data["faces"])), "<u4")
    assert (faces.reshape(-1, 3) == fold.faces).all()
    held = fold.rollout.positions[:, fold.arms[0].grasp.vertex]
    assert np.allclose(data["hands"][0]["path"], held, atol=2e-5)


def test_a_replay_has_its_first_and_last_frame_and_not_too_many() -> None:
    for count, vertices in ((1, 10), (2, 10), (1000, 10), (1000, 100_000)):
        kept = frames(count, vertices)
        assert kept[0] == 0 and kept[-1] == count - 1 and len(kept) <= FRAMES
    assert (frames(100, 10) == np.arange(100)).all()
    assert len(frames(1000, 100_000)) == 10


def test_paths_are_drawn_in_the_plane_of_the_fold(folder: Path) -> None:
    def turn(result: dict[str, Any]) -> None:
        triangle = result["baselines"][1]
        triangle["path"] = [[-y, -x, z] for x, y, z in triangle["path"]]

    changed(folder / "result.json", turn)  # towards -y, as the second fold of a towel in quarters goes
    named = {trace["name"]: trace for trace in plot(Result.load(folder))["data"] if "name" in trace}
    assert "learned, both hands" in named and len(named) == 4
    assert max(named["Triangle"]["y"]) == pytest.approx(200.0)
    assert named["Triangle"]["x"][-1] == pytest.approx(800.0)


def test_hands_that_part_are_drawn_apart(folder: Path) -> None:
    changed(folder / "scene.json", lambda s: s["grippers"][0]["displacements"][5].__setitem__(2, 0.5))
    names = {trace.get("name") for trace in plot(Result.load(folder))["data"]}
    assert {"learned, left hand", "learned, right hand"} <= names


def test_the_map_shows_each_error_at_its_place(folder: Path) -> None:
    def tilt(arrays: dict[str, np.ndarray]) -> None:
        arrays["positions"][-1] = arrays["target"]
        arrays["positions"][-1, :, 2] += 0.001 * (arrays["positions"][0, :, 0] + 0.4)

    rewritten(folder, tilt)
    (chart,) = maps(Result.load(folder))
    heat = chart.plot["data"][0]
    values = np.array(heat["z"], dtype=float)
    x = heat["x0"] + heat["dx"] * np.arange(values.shape[1])
    inside = np.isfinite(values)
    assert chart.title == "The flat cloth" and 0.85 < inside.mean() < 0.95
    assert np.abs(values - (x + 400) / 1000)[inside].max() < 0.011


def test_two_layers_make_two_maps(folder: Path) -> None:
    points, faces = grid(0.1)
    above = points + np.array([0.0, 0.0, 0.002])
    start = np.vstack([points, above])
    both = np.vstack([faces, faces[:, ::-1] + len(points)])

    def double(arrays: dict[str, np.ndarray]) -> None:
        arrays["faces"] = both
        arrays["positions"] = np.repeat(start[None], len(arrays["times"]), axis=0)
        arrays["target"] = start + np.repeat([[0.001, 0, 0], [0.003, 0, 0]], len(points), axis=0)
        for moment in ("error_first", "error_10", "error_50"):
            arrays.pop(moment)

    rewritten(folder, double)

    def cloth(scene: dict[str, Any]) -> None:
        scene["cloth"] |= {"vertices": start.tolist(), "faces": both.tolist()}
        for gripper in scene["grippers"]:
            gripper["vertices"] = [vertex for vertex in gripper["vertices"] if vertex < len(start)]

    changed(folder / "scene.json", cloth)
    high, low = maps(Result.load(folder))
    assert high.title == "Upper layer"
    assert np.nanmean(np.array(high.plot["data"][0]["z"], dtype=float)) == pytest.approx(3.0)
    assert np.nanmean(np.array(low.plot["data"][0]["z"], dtype=float)) == pytest.approx(1.0)


def test_the_scale_of_the_map_is_round_and_not_set_by_one_vertex() -> None:
    errors = np.full(1000, 0.0031)
    errors[0] = 0.5
    assert largest(errors) == pytest.approx(0.004)
    assert largest(np.zeros(5)) == pytest.approx(5e-4)


def test_the_nearest_triangle_is_seen() -> None:
    points = np.array([[0, 0, 0], [8, 0, 0], [0, 8, 0], [0, 0, 1], [4, 0, 1], [0, 4, 1]], dtype=float)
    seen = rasterise(points, np.array([[0, 1, 2], [3, 4, 5]]), (8, 8))
    assert seen.face[1, 1] == 1 and seen.face[4, 2] == 0 and seen.face[7, 7] == -1
    assert seen.mask.sum() == 36
    assert np.allclose(seen.sample(points[:, 0], np.array([[0, 1, 2], [3, 4, 5]]))[:3], [0.5, 1.5, 2.5])


def test_triangles_beyond_the_image_or_edge_on_are_cut_off() -> None:
    beyond = [[-90, -90, 0], [90, -90, 0], [0, 90, 0]]
    off, flat, none = [[9, 9, 5], [20, 9, 5], [9, 20, 5]], [[1, 1, 5], [3, 3, 5], [5, 5, 9]], [[np.nan, 0, 5]] * 3
    seen = rasterise(np.array([*beyond, *off, *flat, *none], dtype=float), np.arange(12).reshape(4, 3), (8, 8))
    assert (seen.face == 0).all()
    assert np.allclose(seen.weights.sum(axis=2), 1.0)


def test_a_view_sees_up_as_up_and_near_as_large() -> None:
    points = np.array([[0, 0, 0], [0, 0.1, 0], [0, 0.1, 1.0]], dtype=float)
    flat = View(np.zeros(3), np.eye(3), 100.0, (40, 60)).project(points)
    assert np.allclose(flat[:, :2], [[30, 20], [30, 10], [30, 10]])
    near = View(np.zeros(3), np.eye(3), 100.0, (40, 60), distance=2.0).project(points)
    assert np.allclose(near[:, 1], [20, 10, 0])
    assert near[2, 2] > near[1, 2]


def test_the_picture_is_a_png_of_cloth_and_paths(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["tatamu.report.still"], "SIZE", (90, 160))
    out = picture(folder, folder / "picture.png")
    with Image.open(out) as image:
        pixels = np.asarray(image)
    assert pixels.shape == (90, 160, 4) and (pixels[..., 3] == 255).all()
    red, green, blue = (pixels[..., k].astype(int) for k in range(3))
    assert ((red > 220) & (green > 150) & (blue < 150)).mean() > 0.05  # the cloth's other side is up
    assert ((red > 150) & (green < 110)).sum() > 20  # left hand
    assert ((red < 80) & (green > 90)).sum() > 20  # right hand


def test_bins_are_round_and_about_forty() -> None:
    for end in (1e-9, 0.0013, 0.02, 0.145, 0.5):
        width = bin_width(end)
        assert float(f"{width:.2g}") == pytest.approx(width)
        assert 25 <= max(end, 1e-6) / width <= 60


def test_a_tube_is_as_thick_everywhere_whatever_way_it_goes() -> None:
    share = np.linspace(0.0, 1.0, 50)[:, None]
    for way in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -0.6, 0.0], [0.0, 0.0, 1.0]):
        path = share * way + np.sin(np.pi * share) * [0.0, 0.0, 0.3]
        points, _ = tube(path, 0.01)
        rings = points.reshape(-1, 10, 3)
        assert np.linalg.norm(rings - rings.mean(axis=1, keepdims=True), axis=2) == pytest.approx(0.01, rel=1e-6)


def test_normals_of_a_flat_cloth_point_up() -> None:
    points, faces = grid(0.1)
    assert np.allclose(vertex_normals(points, faces), [0, 0, 1])
