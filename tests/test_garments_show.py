"""`tatamu garments` lists and `tatamu show` draws."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image

from tatamu.base.errors import InputError
from tatamu.folding.fold import ideal_folds
from tatamu.folding.plans import PLANS
from tatamu.garments import GARMENTS, make_garment
from tatamu.report.garment import FoldMark, diagram, page
from tatamu.show.drawing import FROM_ABOVE, Drawing
from tatamu.show.shapes import Dot, Label, Polyline
from tests.commands import command
from tests.foreign import GOOD


def test_all_garments_are_listed() -> None:
    said = command("garments")
    for name in GARMENTS:
        assert re.search(rf"^{name} ", said, re.MULTILINE)
    assert re.search(r"trousers .* 0.34x0.6 .* usual-trousers", said)


def test_show_writes_a_page_and_a_picture(tmp_path: Path) -> None:
    said = command("show", "tshirt", "--spacing", 0.02, "--fold", "half", "--out", tmp_path / "pictures")
    assert "layers:    2" in said
    text = (tmp_path / "pictures" / "tshirt.html").read_text()
    for word in ("left_sleeve", "back_neck", "half", "fold line"):
        assert f">{word}<" in text or f"> {word}" in text
    assert "http://www.w3.org/2000/svg" in text
    assert not re.search(r'(src|href)="http', text)  # opens offline
    with Image.open(tmp_path / "pictures" / "tshirt.png") as picture:
        assert picture.size[1] == 760


def test_show_draws_foreign_garments_and_says_what_was_done(tmp_path: Path) -> None:
    path = GOOD["disc_stl"](tmp_path)
    said = command("show", path, "--out", tmp_path / "mat.html")
    assert "note: 72 vertices are welded into 25" in said
    assert "72 vertices are welded into 25" in (tmp_path / "mat.html").read_text()


def test_show_refuses_other_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="out: must be"):
        command("show", "towel", "--out", tmp_path / "towel.pdf")


def test_the_left_is_on_the_left_and_the_hem_below() -> None:
    garment = make_garment("tshirt", spacing=0.02)
    drawn = diagram(garment)
    left, hem = (drawn.pixels(garment.vertices[garment.edges[name], :2]).mean(axis=0) for name in ("left_side", "hem"))
    assert left[0] < 0.5 * drawn.wide
    assert hem[1] > 0.6 * drawn.tall


def test_open_edges_are_dashed_and_seams_drawn_through() -> None:
    garment = make_garment("trousers", spacing=0.03)
    assert diagram(garment).svg().count("stroke-dasharray") == len(garment.openings) == 3


def test_svg_and_png_show_the_same() -> None:
    corner, red = np.array([0.25, 0.25]), np.array([[0.5, 0.9], [0.5, 0.1]])
    drawn = Drawing(np.zeros(2), np.ones(2), 100.0, FROM_ABOVE)
    drawn.add(Polyline(red, "#ff0000", 4.0), Dot(corner, "#0000ff", 20.0))
    assert '<circle cx="75.0" cy="75.0" r="20" fill="#0000ff"/>' in drawn.svg()
    assert 'points="10.0,50.0 90.0,50.0"' in drawn.svg()
    pixels = np.asarray(Image.open(io.BytesIO(drawn.png())))
    assert pixels.shape == (100, 100, 3)
    assert (pixels[75, 75] == [0, 0, 255]).all()
    assert (pixels[50, 50] == [255, 0, 0]).all()
    assert (pixels[10, 10] == 255).all()


def test_folds_that_are_handed_over_are_drawn_and_names_are_escaped() -> None:
    garment = make_garment("towel", spacing=0.05)
    line = np.array([[0.0, -0.17], [0.0, 0.17]])
    mark = FoldMark("<b>", line, np.array([1.0, 0.0]), np.array([[-0.4, 0.1]]), np.array([[-0.4, -0.1]]))
    text = page(garment, [mark])
    assert "&lt;b&gt;" in text
    assert "<b>" not in text.split("<figcaption>")[0].split("<figure>")[1]
    assert page(garment, [mark]) == text


@pytest.mark.parametrize(("name", "plan"), [("tshirt", "shop"), ("trousers", "thirds"), ("towel", "quarters")])
def test_the_arrow_of_a_fold_crosses_its_own_line_only_and_no_line_a_name(name: str, plan: str) -> None:
    garment = make_garment(name)
    marks = [
        FoldMark(step.title, fold.line, fold.normal, np.empty((0, 2)), np.empty((0, 2)))
        for step, fold in zip(PLANS[name][plan].steps, ideal_folds(garment, PLANS[name][plan]), strict=True)
    ]
    shapes = diagram(garment, marks).shapes
    lines = [s for s in shapes if isinstance(s, Polyline) and s.colour == "target" and s.width]
    dashed = shapely.MultiLineString([s.points for s in lines if s.dash])
    shafts = [shapely.LineString(s.points) for s in lines if not s.dash and len(s.points) == 2]
    assert len(shafts) == len(marks)
    for shaft in shafts:
        assert len(shapely.get_parts(shaft.intersection(dashed))) == 1
    kinds = [isinstance(shape, Label) for shape in shapes if not isinstance(shape, Dot)]
    names = kinds.index(True)
    assert not any(kinds[:names]) and all(kinds[names : names + len(garment.edges) + len(marks)])


def test_a_line_far_beyond_the_garment_keeps_its_name_in_the_drawing() -> None:
    garment = make_garment("towel", spacing=0.05)
    marks = [
        FoldMark(
            "long", np.array([[0.0, -reach], [0.0, reach]]), np.array([1.0, 0.0]), np.empty((0, 2)), np.empty((0, 2))
        )
        for reach in (5.0, 0.17)
    ]
    far, near = (diagram(garment, [mark]).svg() for mark in marks)
    assert far == near and ">long<" in far
