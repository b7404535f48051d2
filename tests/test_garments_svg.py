"""What an SVG drawing shows is the outline: templates, hidden parts and what is cut away are not."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from tatamu.base.errors import InputError
from tatamu.garments.drawing import DrawnPieces
from tatamu.garments.svg import read_svg
from tests.refusals import refusal

WIDTH, HEIGHT = 340.0, 440.0
PIECE = "M20 20 h300 v400 h-300 z"
"""A rectangle of 300 x 400."""
SHOWN = f'<path d="{PIECE}"/>'
OTHER = '<rect x="5" y="5" width="60" height="80"/>'
XLINK = 'xmlns:xlink="http://www.w3.org/1999/xlink"'


def read(body: str, head: str = f'width="{WIDTH}mm" height="{HEIGHT}mm" viewBox="0 0 {WIDTH} {HEIGHT}"') -> DrawnPieces:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.svg"
        path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {XLINK} {head}>{body}</svg>')
        return read_svg(path)


def boxes(body: str, **how: str) -> list[list[float]]:
    """Left, top, right and bottom of each curve, y down."""
    curves = [curve.points * [1, -1] for piece in read(body, **how).pieces for curve in piece.curves]
    return [np.concatenate([points.min(axis=0), points.max(axis=0)]).round(3).tolist() for points in curves]


WHOLE = [20, 20, 320, 420]
NEVER_DRAWN = {
    "symbol": f'<symbol id="s">{OTHER}</symbol>',
    "mask": f'<mask id="s">{OTHER}</mask>',
    "pattern": f'<pattern id="s" width="9" height="9">{OTHER}</pattern>',
    "marker": f'<marker id="s">{OTHER}</marker>',
    "clip path": f'<clipPath id="s">{OTHER}</clipPath>',
    "definitions": f"<defs><g>{OTHER}</g></defs>",
    "nested template": f'<g><defs><symbol id="s"><g>{OTHER}</g></symbol></defs></g>',
    "no display": f'<g display="none">{OTHER}</g>',
    "no display in a style": f'<g style="opacity: 1; display:none">{OTHER}</g>',
    "no display in a sheet": f'<style>/* a */ .x, .y {{display: none}}</style><g class="z x">{OTHER}</g>',
    "no display by id": f'<style>#q{{display:none !important}}</style><g id="q">{OTHER}</g>',
    "no opacity": f'<g opacity="0">{OTHER}</g>',
    "no opacity in a style": f'<g style="opacity: 0.0%">{OTHER}</g>',
    "not visible": f'<g visibility="hidden">{OTHER}</g>',
    "no width": '<rect x="5" y="5" height="80"/>',
    "second of a switch": f"<switch><g/>{OTHER}</switch>",
    "unknown element": f"<thing>{OTHER}</thing>",
    "white page": '<rect width="100%" height="100%" fill="#FFFFFF"/>',
    "white page as a path": '<path style="fill:white" d="M0 0H340V440H0z"/>',
    "a little more than the page": '<g fill="#fefefe"><rect x="-2" y="-2" width="345" height="446"/></g>',
    "clipped away": f'<clipPath id="k"><path d="M0 0h1v1h-1z"/></clipPath><g clip-path="url(#k)">{OTHER}</g>',
    "outside of a nested svg": f'<svg x="0" y="0" width="4" height="4">{OTHER}</svg>',
}


@pytest.mark.parametrize("kind", NEVER_DRAWN)
@pytest.mark.parametrize("first", [True, False])
def test_what_is_never_drawn_is_no_outline(kind: str, first: bool) -> None:
    body = NEVER_DRAWN[kind] + SHOWN if first else SHOWN + NEVER_DRAWN[kind]
    assert boxes(body) == [WHOLE]


DRAWN = {
    "visible again": f'<g visibility="hidden"><g visibility="visible">{SHOWN}</g></g>',
    "use": f'<defs><path id="a" d="{PIECE}"/></defs><use href="#a"/>',
    "use with an old link": f'<defs><path id="a" d="{PIECE}"/></defs><use xlink:href="#a"/>',
    "use that is moved": '<defs><path id="a" d="M0 0h300v400h-300z"/></defs><use href="#a" x="20" y="20"/>',
    "use of a symbol": '<symbol id="s" viewBox="0 0 3 4"><rect width="3" height="4"/></symbol>'
    '<use href="#s" x="20" y="20" width="300" height="400"/>',
    "use of a symbol that fits by its height": '<symbol id="s" viewBox="0 0 3 4"><rect width="3" height="4"/></symbol>'
    '<use href="#s" x="0" y="20" width="340" height="400"/>',
    "use of a squeezed symbol": '<symbol id="s" viewBox="0 0 1 1" preserveAspectRatio="none">'
    '<rect width="1" height="1"/></symbol><use href="#s" x="20" y="20" width="300" height="400"/>',
    "nested svg": '<svg x="20" y="20" width="300" height="400" viewBox="5 6 30 40"><rect x="5" y="6" width="30" '
    'height="40"/></svg>',
    "nested svg in percent": '<svg x="20" y="20" width="300" height="400"><rect width="100%" height="100%"/></svg>',
    "clip path of the page": f'<clipPath id="k"><rect width="340" height="440"/></clipPath><g clip-path="url(#k)">'
    f"{SHOWN}</g>",
    "clip path that cuts": '<clipPath id="k"><rect x="20" y="20" width="300" height="400"/></clipPath>'
    '<path clip-path="url(#k)" d="M0 0h340v440h-340z"/>',
    "clip path by a class": '<style>.c{clip-path:url(#k)}</style><clipPath id="k"><rect x="20" y="20" width="300" '
    'height="400"/></clipPath><g class="c"><path d="M0 0h340v440h-340z"/></g>',
    "clip path in parts of the shape": '<clipPath id="k" clipPathUnits="objectBoundingBox"><rect width="1" '
    'height="0.5"/></clipPath><rect x="20" y="20" width="300" height="800" clip-path="url(#k)"/>',
    "clip path of a moved shape": '<clipPath id="k"><rect width="300" height="400"/></clipPath>'
    '<g transform="translate(20,20)" clip-path="url(#k)"><path d="M-9 -9h340v440h-340z"/></g>',
    "white mask": '<mask id="m"><rect x="20" y="20" width="300" height="400" fill="#fff"/></mask>'
    '<g mask="url(#m)"><path d="M0 0h340v440h-340z"/></g>',
    "page without a fill": f'<rect width="0" height="440" fill="none"/>{SHOWN}',
    "style transform": '<path style="transform: translate(20px,20px)" d="M0 0h300v400h-300z"/>',
    "switch": f"<switch><foreignObject requiredExtensions='x'/><g>{SHOWN}</g></switch>",
}


@pytest.mark.parametrize("kind", DRAWN)
def test_what_is_drawn_is_the_outline(kind: str) -> None:
    assert boxes(DRAWN[kind]) == [WHOLE]


def test_lengths_with_a_unit_are_of_96_to_the_inch() -> None:
    assert boxes('<rect x="1in" y="0" width="96pt" height="6pc"/>') == [[96, 0, 224, 96]]


def test_a_white_piece_of_the_page_alone_is_the_outline() -> None:
    assert boxes('<rect width="100%" height="100%" fill="white"/>') == [[0, 0, WIDTH, HEIGHT]]


def test_a_background_is_told() -> None:
    remarks = read(f'<rect width="100%" height="100%" fill="white"/>{SHOWN}').pieces[0].remarks
    assert remarks == ("left out: a white rectangle of the page's size",)


@pytest.mark.parametrize(
    ("body", "named"),
    [
        (f'<mask id="m"><rect width="99" height="99" fill="#333"/></mask><g mask="url(#m)">{SHOWN}</g>', "mask"),
        (f'<g clip-path="circle(40%)">{SHOWN}</g>', "clip-path"),
        (f'<g transform="rotate(9)" transform-origin="50% 50%">{SHOWN}</g>', "transform-origin"),
        ('<use href="other.svg#a"/>', "other.svg"),
        ('<rect width="3em" height="9"/>', "width must be"),
        ('<g id="a"><use href="#a"/></g>', "refers to itself"),
        ('<clipPath id="k"><path clip-path="url(#k)" d="M0 0h9v9z"/></clipPath><rect clip-path="url(#k)" width="9" '
         'height="9"/>', "refers to itself"),
    ],
)  # fmt: skip
def test_what_is_not_supported_is_named(body: str, named: str) -> None:
    assert re.search(named, refusal(read, body))


def test_percentages_of_a_page_without_a_size_are_refused() -> None:
    with pytest.raises(InputError, match=r"width must be a length if the page has no size, given 50%"):
        read('<rect width="50%" height="9"/>', head="")


PARTS = st.integers(1, 99)


@settings(max_examples=40, deadline=None)
@given(width=PARTS, height=PARTS, x=st.integers(0, 50), y=st.integers(0, 50))
def test_percentages_are_of_their_own_side(width: int, height: int, x: int, y: int) -> None:
    """The sides of the page differ, and so do those of a nested part."""
    one = boxes(f'<rect x="{x}%" y="{y}%" width="{width}%" height="{height}%"/>')
    left, top = x * WIDTH / 100, y * HEIGHT / 100
    assert one == [pytest.approx([left, top, left + width * WIDTH / 100, top + height * HEIGHT / 100], abs=2e-3)]
    inner = '<svg x="0" y="0" width="200" height="50" viewBox="0 0 20 5" overflow="visible">BODY</svg>'
    nested = boxes(inner.replace("BODY", f'<ellipse cx="{x}%" cy="{y}%" rx="{width}%" ry="{height}%"/>'))
    middle = np.array([2 * x, 0.5 * y])
    reach = np.array([2 * width, 0.5 * height])
    assert nested == [pytest.approx([*(middle - reach), *(middle + reach)], abs=2e-3)]


@settings(max_examples=40, deadline=None)
@given(sides=st.lists(st.integers(0, 340), min_size=4, max_size=4, unique=True), hole=st.booleans())
def test_a_clip_path_leaves_the_common_part(sides: list[int], hole: bool) -> None:
    left, right = sorted(sides[:2])
    top, bottom = sorted(sides[2:])
    clip = f'<clipPath id="k"><rect x="{left}" y="{top}" width="{right - left}" height="{bottom - top}"/></clipPath>'
    ring = "M 40 40 V 300 H 300 V 40 Z" if hole else ""
    wanted = shapely.box(20, 20, 320, 420).intersection(shapely.box(left, top, right, bottom))
    cutout = shapely.box(40, 40, 300, 300).intersection(shapely.box(left, top, right, bottom))
    drawn = read(f'{clip}<path clip-path="url(#k)" d="{PIECE} {ring}"/>')
    found = [shapely.Polygon(curve.points).area for piece in drawn.pieces for curve in piece.curves]
    expected = [each.area for each in (wanted, *([cutout] if hole else [])) if each.area > 0]
    assert sorted(found) == pytest.approx(sorted(expected), rel=1e-6)


@pytest.mark.parametrize("opacity", ["1", "0"])
def test_an_open_line_is_cut_by_a_clip_path_whatever_its_opacity(opacity: str) -> None:
    clip = f'<clipPath id="k"><rect width="100" height="440" opacity="{opacity}"/></clipPath>'
    assert boxes(f'{clip}<line clip-path="url(#k)" x1="20" y1="9" x2="300" y2="9"/>') == [[20, 9, 100, 9]]


def test_a_clip_path_with_a_hole_keeps_its_rule() -> None:
    """Both curves turn the same way: the inner one is a hole by the rule evenodd only."""
    path = "M0 0h340v440h-340z M100 100h100v100h-100z"
    for rule, count in (("evenodd", 2), ("nonzero", 1)):
        clip = f'<clipPath id="k"><path clip-rule="{rule}" d="{path}"/></clipPath>'
        assert len(boxes(f'{clip}<path clip-path="url(#k)" d="{PIECE}"/>')) == count
