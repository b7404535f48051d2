"""Patterns as CAD and drawing programs write them: pieces, layers with a meaning, names, units."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.garments import Garment, make_garment
from tests.commands import command
from tests.foreign import svg, written
from tests.patterns import (
    HOODIE,
    ILLUSTRATOR,
    INKSCAPE,
    NAMED,
    POCKET,
    aama_dxf,
    half_dxf,
    hoodie_svg,
    inserted_dxf,
)
from tests.refusals import refusal

OPEN = 'openings = ["bottom", "top"]'


def described(path: Path, *lines: str) -> Garment:
    """The garment of a file with these lines in its garment file, coarsely meshed."""
    text = "\n".join(["[garment]", f'outline = "{path.name}"', "spacing = 0.03", *lines])
    return make_garment(str(written(path.parent, "garment.toml", text + "\n")))


def drawn(folder: Path, head: str, body: str = "", scale: float = 1.0) -> Path:
    """The path of a drawing of the hoodie."""
    return written(folder, "hoodie.svg", hoodie_svg(head, body, scale=scale))


@pytest.mark.parametrize("units", ["METRIC", "ENGLISH"])
def test_the_garment_file_chooses_a_piece_of_a_pattern(units: str, tmp_path: Path) -> None:
    front = described(aama_dxf(tmp_path, units), 'piece = "front"')
    assert front.size == pytest.approx((0.54, 0.46), abs=1e-4)
    assert ("inches" if units == "ENGLISH" else "millimetres") in front.reading
    assert f"UNITS: {units}" in front.reading
    sleeve = described(tmp_path / "shirt.dxf", 'piece = "SLEEVE"')
    assert sleeve.size == pytest.approx((0.22, 0.14), abs=1e-4)


def test_several_pieces_are_listed_with_their_sizes(tmp_path: Path) -> None:
    path = aama_dxf(tmp_path)
    said = refusal(make_garment, str(path))
    assert 'piece = "FRONT" under [garment]' in said
    assert '"BACK" (0.46 x 0.54 m)' in said and '"SLEEVE" (0.14 x 0.22 m)' in said
    with pytest.raises(InputError, match=r'piece: must be one of "FRONT".*given \'HOOD\''):
        described(path, 'piece = "HOOD"')


def test_the_grain_line_turns_the_piece_so_that_it_runs_along_the_length(tmp_path: Path) -> None:
    path = aama_dxf(tmp_path)
    front = described(path, 'piece = "FRONT"')
    assert front.size == pytest.approx((0.54, 0.46), abs=1e-4)
    hem = front.vertices[front.edges["bottom"]]
    assert np.ptp(hem[:, 1]) == pytest.approx(0.32, abs=1e-3)
    assert any("grain line" in note for note in front.notes)
    as_drawn = described(path, 'piece = "FRONT"', "grain = false")
    assert as_drawn.size == pytest.approx((0.46, 0.54), abs=1e-4)
    assert front.fibre is None and as_drawn.fibre is not None
    assert np.abs(as_drawn.fibre) == pytest.approx(np.array([[0.0, 1.0, 0.0]]))
    over = described(path, 'piece = "FRONT"', 'up = "-x"')
    assert np.ptp(over.vertices[over.edges["top"], 1]) == pytest.approx(0.32, abs=1e-3)


def test_notches_grain_and_internal_lines_are_no_openings_and_no_holes(tmp_path: Path) -> None:
    front = described(aama_dxf(tmp_path), 'piece = "FRONT"', "layers = 2", OPEN)
    assert front.layers == 2
    assert set(front.openings) == {"bottom", "top"}
    assert not any(name.startswith("hole") for name in front.edges)


def test_a_piece_is_as_large_as_it_is_sewn(tmp_path: Path) -> None:
    front = described(aama_dxf(tmp_path, seam=10.0), 'piece = "FRONT"')
    assert front.size == pytest.approx((0.54, 0.46), abs=1e-3)
    assert any("sew line (layer 14)" in note for note in front.notes)


@pytest.mark.parametrize(
    ("code", "metres", "name"), [(4, 1e-3, "millimetres"), (5, 1e-2, "centimetres"), (1, 0.0254, "inches")]
)
def test_the_header_gives_the_unit_where_no_text_does(code: int, metres: float, name: str, tmp_path: Path) -> None:
    front = described(inserted_dxf(tmp_path, code, metres))
    assert front.size == pytest.approx((0.54, 0.46), abs=1e-4)
    assert front.reading == f"read in {name} (DXF, $INSUNITS {code})"


@pytest.mark.parametrize("unit", ["70\n1", "40\n1e400"])
def test_the_text_of_a_pattern_goes_before_the_header(tmp_path: Path, unit: str) -> None:
    path = aama_dxf(tmp_path)
    header = f"0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n9\n$INSUNITS\n{unit}\n0\nENDSEC\n"
    path.write_text(header + path.read_text())
    assert described(path, 'piece = "FRONT"').size == pytest.approx((0.54, 0.46), abs=1e-4)


def test_half_a_piece_is_unfolded_along_its_mirror_line(tmp_path: Path) -> None:
    back = described(half_dxf(tmp_path), 'up = "x"')
    assert back.size == pytest.approx((0.54, 0.46), abs=1e-3)
    assert any("mirror line" in note for note in back.notes)


def test_pieces_of_an_svg_are_chosen_by_their_names(tmp_path: Path) -> None:
    body = '<rect id="front" width="200" height="400"/><rect id="rect9" x="300" width="200" height="300"/>'
    assert described(written(tmp_path, "two.svg", svg(body)), 'piece = "piece 2"').size == pytest.approx((0.2, 0.3))
    assert described(tmp_path / "two.svg", 'piece = "front"').size == pytest.approx((0.2, 0.4))


def test_the_advice_on_pieces_chooses_a_piece_whatever_the_names_are(tmp_path: Path) -> None:
    body = '<rect id="{}" width="200" height="400"/><rect id="{}" x="300" width="200" height="300"/>'
    for number, ids in enumerate([("a&quot;b\\", "c"), ("front", "FRONT"), ("x \u202e y", "z")]):
        path = written(tmp_path, f"{number}.svg", svg(body.format(*ids)))
        advice = refusal(make_garment, str(path)).partition("choose one with ")[2].partition(" under [garment]")[0]
        assert described(path, advice).size == pytest.approx((0.2, 0.4)), ids


VIEW = 'viewBox="0 0 620 710"'
NEW, OLD = (INKSCAPE.format(version=version) for version in ("1.3.2", "0.48.4 r9939"))
SVGS = {
    "mm": (hoodie_svg(f'width="620mm" height="710mm" {VIEW}'), "millimetres (SVG, width 620mm)"),
    "cm": (hoodie_svg('width="62cm" viewBox="0 0 62 71"', scale=0.1), "centimetres (SVG, width 62cm)"),
    "px": (
        hoodie_svg('width="2343.307px" height="2683.465px"', scale=96 / 25.4),
        "pixels of 1/96 inch (SVG, width 2343.307px, no viewBox)",
    ),
    "bare": (
        hoodie_svg('width="2343.307" viewBox="0 0 2343.307 2683.465"', scale=96 / 25.4),
        "pixels of 1/96 inch (SVG, width 2343.307)",
    ),
    "px for mm": (
        hoodie_svg(f'width="2343.307" height="2683.465" {VIEW}'),
        "pixels of 1/96 inch (SVG, width 2343.307)",
    ),
    "pt": (
        hoodie_svg('width="1757.48pt" viewBox="0 0 1757.48 2012.6"', scale=72 / 25.4),
        "points of 1/72 inch (SVG, width 1757.48pt)",
    ),
    "Illustrator": (
        hoodie_svg('width="1757.48px" viewBox="0 0 1757.48 2012.6"', "", ILLUSTRATOR, 72 / 25.4),
        "points of 1/72 inch (Illustrator SVG, width 1757.48px)",
    ),
    "Illustrator for screens": (
        hoodie_svg('id="Layer_1" data-name="Layer 1" viewBox="0 0 1757.48 2012.6"', scale=72 / 25.4),
        "points of 1/72 inch (Illustrator SVG without a width)",
    ),
    "Inkscape": (
        hoodie_svg(f'{NEW} width="620mm" height="710mm" {VIEW}'),
        "millimetres (Inkscape SVG, width 620mm)",
    ),
    "old Inkscape": (
        hoodie_svg(f'{OLD} width="2196.85" height="2515.75"', scale=90 / 25.4),
        "pixels of 1/90 inch (Inkscape SVG, width 2196.85, no viewBox)",
    ),
    "none": (hoodie_svg(VIEW), "millimetres (assumed: the SVG has no width)"),
}


@pytest.mark.parametrize("kind", SVGS)
def test_the_size_of_an_svg_is_that_of_the_program_that_wrote_it(kind: str, tmp_path: Path) -> None:
    text, words = SVGS[kind]
    hoodie = make_garment(str(written(tmp_path, "hoodie.svg", text)), spacing=0.03)
    assert hoodie.size == pytest.approx((0.62, 0.71), rel=1e-5)
    assert hoodie.statement == f"hoodie: 0.62 x 0.71 m, read in {words}"


def test_a_viewbox_is_fitted_into_width_and_height(tmp_path: Path) -> None:
    wide = drawn(tmp_path, f'width="1240mm" height="710mm" {VIEW}')
    assert make_garment(str(wide), spacing=0.03).size == pytest.approx((0.62, 0.71))
    stretched = drawn(tmp_path, f'width="1240mm" height="710mm" {VIEW} preserveAspectRatio="none"')
    said = refusal(make_garment, str(stretched))
    assert "page and viewBox must have the same aspect ratio, because preserveAspectRatio = none" in said


def test_a_scale_goes_before_what_the_file_says(tmp_path: Path) -> None:
    made = described(drawn(tmp_path, f'width="620px" {VIEW}'), "scale = 0.001")
    assert made.statement == "garment: 0.62 x 0.71 m, read in millimetres (scale 0.001)"


def test_a_wrong_unit_is_refused_with_the_place_of_the_scale(tmp_path: Path) -> None:
    small = drawn(tmp_path, 'width="62mm" viewBox="0 0 62 71"', scale=0.1)
    assert make_garment(str(small)).size == pytest.approx((0.062, 0.071))
    said = refusal(make_garment, str(drawn(tmp_path, 'width="6.2mm" viewBox="0 0 62 71"', scale=0.1)))
    assert "give scale = 0.01 under [garment] in a garment file, or --scale 0.01" in said


def test_a_small_garment_of_an_assumed_unit_is_doubted(tmp_path: Path) -> None:
    made = make_garment(str(drawn(tmp_path, 'viewBox="0 0 62 71"', scale=0.1)))
    assert any("is the file in centimetres?" in note for note in made.notes)


def test_inner_open_paths_without_a_name_are_no_openings(tmp_path: Path) -> None:
    hoodie = make_garment(str(drawn(tmp_path, f'{NEW} width="620mm" {VIEW}', POCKET)), spacing=0.03)
    assert hoodie.layers == 1
    assert any(note.startswith("the garment has one layer, because no opening is named") for note in hoodie.notes)


def test_a_label_is_a_name_and_a_pocket_with_a_name_is_no_opening(tmp_path: Path) -> None:
    pocket = POCKET.replace('id="path815"', 'id="pocket"')
    hoodie = make_garment(str(drawn(tmp_path, f'{NEW} width="620mm" {VIEW}', pocket + NAMED)), spacing=0.03)
    assert hoodie.openings == ("hem",)
    assert any(note.startswith("curve pocket is not an opening") for note in hoodie.notes)


def test_openings_of_the_garment_file_win(tmp_path: Path) -> None:
    given = described(
        drawn(tmp_path, f'{NEW} width="620mm" {VIEW}', POCKET + NAMED), "openings = {neck = [[260, 0], [360, 0]]}"
    )
    assert given.openings == ("neck",)
    named = described(tmp_path / "hoodie.svg", 'openings = ["hem", "top"]')
    assert set(named.openings) == {"hem", "top"}


def test_the_group_of_a_path_is_not_its_name(tmp_path: Path) -> None:
    body = f'<g id="front"><path d="{HOODIE}"/><path d="M 210 600 L 410 600"/></g>'
    assert make_garment(str(written(tmp_path, "hoodie.svg", svg(body, 620, 710))), spacing=0.03).layers == 1


def test_layers_that_are_asked_for_are_no_news(tmp_path: Path) -> None:
    assert described(drawn(tmp_path, f'width="620mm" {VIEW}'), "layers = 1").notes == ()


def test_a_narrow_garment_gets_a_spacing_that_fits_it(tmp_path: Path) -> None:
    tie = str(written(tmp_path, "tie.svg", svg('<rect width="50" height="600"/>', 50, 600)))
    assert make_garment(tie).spacing <= 0.0125
    assert "given 0.05 m" in refusal(make_garment, tie, spacing=0.05)


def test_a_spacing_that_nobody_gave_is_not_named(tmp_path: Path) -> None:
    slot = "M0 0H400V300H202V20H198V300H0Z"  # two parts 4 mm apart
    (tmp_path / "slot.svg").write_text(svg(f'<path d="{slot}"/>', 400, 300))
    try:
        made = make_garment(str(tmp_path / "slot.svg"))
    except InputError as refused:
        assert "for a mesh; give a smaller spacing" in str(refused)
        assert "0.0" not in str(refused)
    else:
        assert made.spacing < 0.0129


POINT = "0\nSECTION\n2\nENTITIES\n0\nPOINT\n8\n0\n10\n1\n20\n1\n0\nENDSEC\n0\nEOF\n"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("empty.svg", svg(""), "must contain a curve"),
        ("words.svg", svg("<text>hi</text>"), "must contain a curve"),
        ("nan.svg", svg('<path d="M 0 0 L nan 3 L 5 5 Z"/>'), "must have valid path data"),
        ("page.svg", "<html><body/></html>", "is not an SVG file (the file contains <html>)"),
        ("numbers.svg", '<svg viewBox="a b c d"/>', "is not an SVG file"),
        ("point.dxf", POINT, "must contain a curve"),
        ("empty.dxf", "", "is not a DXF file"),
    ],
)
def test_a_drawing_without_curves_is_one_clear_line(name: str, text: str, words: str, tmp_path: Path) -> None:
    assert words in refusal(make_garment, str(written(tmp_path, name, text)))


def test_graded_pieces_are_named_by_their_blocks(tmp_path: Path) -> None:
    path = aama_dxf(tmp_path)
    path.write_text(path.read_text().replace("Piece Name: BACK", "Piece Name: FRONT"))
    with pytest.raises(InputError, match=r'"FRONT-M" .*"BACK-M" .*"SLEEVE"'):
        make_garment(str(path))


def test_a_message_names_the_piece(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="given 'waist'; piece \"FRONT\""):
        described(aama_dxf(tmp_path), 'piece = "FRONT"', 'openings = ["waist"]')


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('up = "z"', "for an outline"),
        ("size = [540, 460]", "size.0: must be from 0.05 to 5 m, given 540 m"),
        ("spacing = 0", "spacing: must be above 0 m"),
        ("scale = 0", "metres per unit"),
    ],
)
def test_wrong_lengths_are_refused_in_their_unit(line: str, words: str, tmp_path: Path) -> None:
    drawn(tmp_path, f'width="620mm" {VIEW}')
    garment = written(tmp_path, "wrong.toml", f'[garment]\noutline = "hoodie.svg"\n{line}\n')
    assert words in refusal(make_garment, str(garment))


def test_the_size_that_was_understood_is_stated_by_show_and_on_its_page(tmp_path: Path) -> None:
    drawn(tmp_path, f'{NEW} width="620mm" {VIEW}')
    said = command("show", tmp_path / "hoodie.svg", "--spacing", 0.03, "--out", tmp_path / "hoodie.html")
    assert said.startswith("hoodie: 0.62 x 0.71 m, read in millimetres (Inkscape SVG, width 620mm)\n")
    assert "read in millimetres (Inkscape SVG, width 620mm)" in (tmp_path / "hoodie.html").read_text()
    assert command("show", "towel", "--out", tmp_path / "towel.html").startswith("towel: 0.34 x 0.80 m\n")


def test_the_command_line_takes_a_scale(tmp_path: Path) -> None:
    drawn(tmp_path, VIEW, scale=1.0)
    arguments = ("show", tmp_path / "hoodie.svg", "--spacing", 0.03, "--out", tmp_path / "hoodie.html")
    assert command(*arguments, "--scale", 0.002).startswith("hoodie: 1.24 x 1.42 m, read in units of 0.002 m (scale")
    with pytest.raises(InputError, match="scale: must be above 0"):
        command(*arguments, "--scale", -1)
    with pytest.raises(InputError, match="scale: must be left out for the built-in garment"):
        command("show", "towel", "--scale", 0.1, "--out", tmp_path / "towel.html")


def test_learn_states_the_size_before_the_first_trial_and_keeps_the_scale(tmp_path: Path) -> None:
    square = '<svg xmlns="http://www.w3.org/2000/svg"><rect width="30" height="40"/></svg>'
    (tmp_path / "cloth.svg").write_text(square)
    out = tmp_path / "run"
    size = ("--scale", 0.01, "--spacing", 0.04)
    said = command("learn", tmp_path / "cloth.svg", *size, "--trials", 1, "--no-baselines", "--out", out)
    stated = "cloth: 0.30 x 0.40 m, read in centimetres (scale 0.01)\nnote: the garment has one layer"
    assert stated in said and said.index(stated) < said.index("trial")
    assert json.loads((out / "result.json").read_text())["asked"]["scale"] == 0.01
