"""The toolkit that pages are made with: colours, scripts, drawings, pictures."""

from __future__ import annotations

import io
import json
import re
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import tatamu
from tatamu.show.chart import harmless, log_axis, traces
from tatamu.show.drawing import FROM_ABOVE, Drawing
from tatamu.show.image import png
from tatamu.show.page import script
from tatamu.show.palette import BACK, COLOURS, FRONT, REAR, SIDES, css, rgb
from tatamu.show.raster import View
from tatamu.show.replay import replay_data
from tatamu.show.shading import cloth, see, shade
from tatamu.show.shapes import Box, Dot, Label, Picture, Segments
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth
from tests.scenes import scene

SOURCE = Path(tatamu.__file__).parent
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def drawing() -> Drawing:
    """One of each shape on a square metre from above."""
    drawn = Drawing(np.zeros(2), np.ones(2), 100.0, FROM_ABOVE, caption=("a & b", "below"), words="a <test>")
    drawn.add(Box(np.array([0.1, 0.1]), np.array([0.3, 0.2]), "grip", "muted"), Dot(np.array([0.5, 0.5]), "left"))
    drawn.add(Segments(np.array([[[0.0, 0.0], [1.0, 1.0]]]), "mesh"))
    drawn.line([[0.2, 0.8], [0.9, 0.8]], "ink", dash=3.0, fill="cloth")
    drawn.dimension([0.2, 0.5], [0.8, 0.5], "<height>")
    drawn.ruler([0.6, 0.1])
    return drawn


def test_every_colour_that_is_named_is_in_the_palette() -> None:
    files = [path for path in SOURCE.rglob("*") if path.suffix in {".py", ".js", ".html", ".css"}]
    texts = {path.name: path.read_text() for path in files}
    in_charts = {name for text in texts.values() for name in re.findall(r'"@([a-z][a-z0-9-]*)"', text)}
    assert len(in_charts) > 8 and in_charts - {"name"} <= set(COLOURS)
    in_styles = {name for text in texts.values() for name in re.findall(r"var\(--([a-z][a-z0-9-]*)[),]", text)}
    assert in_styles - set(COLOURS) == {"tone", "shadow", "at", "share"}, "all others are set beside their use"


def test_day_and_night_differ_in_contrast_not_in_meaning() -> None:
    assert "prefers-color-scheme: dark" in css()
    for name in ("front", "rear", "back", "target", "left", "right", "scale-0", "scale-4"):
        assert len(set(COLOURS[name])) == 1, f"{name} means the same by day and by night"
    for light, dark in (COLOURS["ink"], COLOURS["paper"]):
        assert abs(int(light[1:3], 16) - int(dark[1:3], 16)) > 150


def test_modules_of_a_script_share_no_name_and_come_before_their_users() -> None:
    for entry in ("plain_page.js", "replay_page.js"):
        text = str(script(entry))
        names = re.findall(r"^(?:async )?(?:const|let|class|function) (\w+)", text, re.MULTILINE)
        assert len(names) > 3 and max(Counter(names).values()) == 1
        assert not re.search(r"^(import|export) ", text, re.MULTILINE)
    assert text.index("const vector") < text.index("class Motion") < text.index("class Viewer") < text.index("start(")
    assert "class Viewer" not in script("plain_page.js")


def test_a_drawing_is_well_formed_and_whole_in_itself(drawing: Drawing) -> None:
    root = ElementTree.fromstring(drawing.svg())
    assert root.get("aria-label") == "a <test>"
    texts = ["".join(text.itertext()) for text in root.iter(f"{SVG}text")]
    assert set(texts) == {"a & b", "below", "<height>", "10 cm"}
    style = "".join(root.find(f"{SVG}style").itertext())  # type: ignore[union-attr]
    used = {name for element in root.iter() for name in (element.get("class") or "").split()}
    assert {"fill-grip", "stroke-muted", "stroke-mesh", "fill-cloth", "stroke-ink", "fill-card"} <= used
    for name in used:
        light, dark = COLOURS[name.partition("-")[2]]
        assert (f".{name}{{" in style) == (light != dark)


def test_what_is_left_of_a_robot_is_left_in_a_drawing_from_above(drawing: Drawing) -> None:
    (x, y), (left, ahead) = drawing.pixels(np.array([[0.5, 0.5], [0.9, 0.8]]))
    assert left < x and ahead < y


def test_a_dimension_has_its_name_beside_it(drawing: Drawing) -> None:
    flat = Drawing(np.zeros(2), np.ones(2), 100.0)
    flat.dimension([0.2, 0.5], [0.8, 0.5], "width")
    flat.dimension([0.5, 0.2], [0.5, 0.8], "height")
    width, height = (shape for shape in flat.shapes if isinstance(shape, Label))
    assert np.allclose(width.towards, [0.0, 1.0]) and np.allclose(height.towards, [1.0, 0.0])


def test_a_drawing_as_pixels_shows_its_shapes_by_day(drawing: Drawing) -> None:
    pixels = np.asarray(Image.open(io.BytesIO(drawing.png())))
    assert pixels.shape == (100, 100, 3)
    assert "#{:02x}{:02x}{:02x}".format(*pixels[80, 84]) == COLOURS["grip"][0]
    drawing.add(Picture("data:,"))
    with pytest.raises(TypeError, match="SVG only"):
        drawing.png()


def test_a_picture_comes_back_whole() -> None:
    pixels = np.random.default_rng(0).integers(0, 256, size=(5, 7, 4)).astype(np.uint8)
    assert (np.asarray(Image.open(io.BytesIO(png(pixels)))) == pixels).all()
    assert png(pixels) == png(pixels)


def test_names_in_a_plot_are_no_links() -> None:
    name = "<a href='javascript:alert(1)'>x</a><span style='color:red'><BR><b onclick=1>"
    made = traces([{"name": name, "x": [1.0, None], "hovertemplate": f"{name}<br>l<sub>x</sub><extra></extra>"}])
    shown = harmless(made)
    escaped = name.replace("<", "&lt;")
    assert shown["data"][0]["name"] == escaped
    assert shown["data"][0]["hovertemplate"] == f"{escaped}<br>l<sub>x</sub><extra></extra>"
    assert shown["data"][0]["x"] == [1.0, None] and shown["layout"] == made["layout"]


def test_a_short_logarithmic_axis_has_numbers_on_it() -> None:
    short = log_axis("x", 3.5, 6.5)
    assert {"4", "5", "6"} <= set(short["ticktext"])
    assert "ticktext" not in log_axis("x", 1.0, 5000.0)


def test_a_legend_lies_above_the_plot_so_that_a_phone_has_room_for_both() -> None:
    legend = traces([], showlegend=True)["layout"]["legend"]
    assert legend["orientation"] == "h"
    assert legend["y"] > 1.0 and legend["yanchor"] == "bottom"


BACK_AND_FRONT = np.array([[0, 3, 1], [0, 1, 2]])
"""A triangle that faces down below one that faces up, joined by a seam."""
PLACES = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.1, -0.001]])


def replayed(faces: np.ndarray) -> dict[str, object]:
    places = PLACES[: faces.max() + 1]
    sheet = scene(cloth=Cloth(vertices=places, faces=faces), grippers=[])
    positions = np.repeat(places[None], 2, axis=0)
    return replay_data(Rollout(np.array([0.0, 1.0]), positions, faces, {}, {"target": places}), sheet, [], 0.01)


def test_front_and_back_of_a_garment_are_told_apart_in_the_replay() -> None:
    two = replayed(BACK_AND_FRONT)
    assert (two["upper"], two["layers"]) == (1, 2)
    one = replayed(BACK_AND_FRONT[1:])
    assert (one["upper"], one["layers"]) == (1, 1)
    names = dict(SIDES[2])
    assert names == {"front": "outside of the front", "rear": "outside of the back", "back": "inside"}
    assert dict(SIDES[1]) == {"front": "side up at the start", "back": "other side"}


@pytest.mark.parametrize(
    ("lower", "turned", "colour"),
    [(False, False, FRONT), (False, True, BACK), (True, False, BACK), (True, True, REAR)],
)
def test_each_side_of_each_layer_has_its_colour_from_above(lower: bool, turned: bool, colour: str) -> None:
    """A back faces down as it lies, so that it shows its inside from above, and its outside when it is turned."""
    faces = BACK_AND_FRONT[:1] if lower else BACK_AND_FRONT[1:]
    mesh = cloth(PLACES * ([1, -1, -1] if turned else [1, 1, 1]), faces, lower=np.array([lower]))
    view = View(np.zeros(3), np.eye(3), 1000.0, (240, 240))
    visible, _ = see(view, mesh)
    light = shade(view, mesh, visible).mean(axis=0)
    wanted = rgb(colour)
    assert light / light.sum() == pytest.approx(wanted / wanted.sum(), abs=1e-6)


def test_points_that_are_no_numbers_are_gaps() -> None:
    plot = traces([{"x": [1.0, 2.0], "y": [float("nan"), 3]}])
    assert plot["data"][0]["y"] == [None, 3]
    json.dumps(plot, allow_nan=False)
