"""`tatamu outline`: a photo of a flat garment in, its outline out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from tatamu.cli.app import app
from tatamu.errors import InputError
from tatamu.size import parse_size

if TYPE_CHECKING:
    from tatamu.garments.photo import Photo

FARTHEST = 1e6
"""Largest coordinate of a given pixel."""


@app.command()
def outline(
    photo: Annotated[Path, typer.Argument(metavar="PHOTO", help="Taken from above, hem down, table all around.")],
    out: Annotated[Path, typer.Option(metavar="OUTLINE.svg", help="File of the outline.")],
    width: Annotated[float | None, typer.Option(help="Width of the garment, its largest, in metres.")] = None,
    ruler: Annotated[
        str | None, typer.Option(metavar="'X,Y X,Y LENGTH'", help="Two pixels, and their distance in metres.")
    ] = None,
    sheet: Annotated[
        str | None,
        typer.Option(
            metavar="'X,Y X,Y X,Y X,Y WxH'",
            help="Corners of a sheet of paper on the table (top left, top right, bottom right, bottom left) and its "
            "size in metres; removes the perspective.",
        ),
    ] = None,
    garment: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="tshirt: find its hem, sleeves and neck as well, and write a garment file of two layers.",
        ),
    ] = None,
    join: Annotated[
        bool,
        typer.Option(
            "--join", help="Count all regions that stand out as the garment, for a garment in several colours."
        ),
    ] = False,
) -> None:
    """Find the outline of a garment on a photo, and draw it on the photo for you to check.

    Examples:
    `tatamu outline shirt.jpg --width 0.52 --out shirt.svg`

    `tatamu outline shirt.jpg --sheet '80,90 700,84 706,520 76,524 0.297x0.210' --out shirt.svg`

    `tatamu outline shirt.jpg --width 0.52 --garment tshirt --out shirt.svg`

    Then run `tatamu show shirt.svg`. A garment file names the parts that are open (docs/reference/garment-file.md).
    With --garment this file, shirt.toml, is written too: `tatamu show shirt.toml --fold shop`.
    """
    from tatamu.files import check_targets, replacing, write_text
    from tatamu.garments.landmarks import tshirt_openings
    from tatamu.garments.photo import find_outline, outline_svg, straightened
    from tatamu.garments.resolution import check_size

    given = [value for value in (width, ruler, sheet) if value is not None]
    if len(given) != 1:
        raise InputError(f"width, ruler, sheet: must give one of them, given {len(given)}")
    if out.suffix.lower() != ".svg":
        raise InputError(f"out: must be an .svg file, given {out}")
    if garment not in (None, "tshirt"):
        raise InputError(f"garment: must be tshirt, given {garment!r}; openings of others go into a garment file")
    picture = out.with_name(f"{out.stem}-on-photo.jpg")
    described = [out.with_suffix(".toml")] if garment else []
    check_targets([out, picture, *described], [photo])
    found = find_outline(photo, join, None if sheet is None else _corners(sheet).mean(axis=0)[None])
    curve = straightened(found.outline, to_metres(found, width, ruler, sheet))
    across, along = np.ptp(curve, axis=0)
    try:
        check_size((across, along))
    except InputError as error:
        raise InputError(f"{error}: were all lengths given in metres?") from None
    openings = tshirt_openings(curve) if garment else {}
    with replacing(picture) as temporary:
        temporary.write_bytes(_overlay(found, openings))
    write_text(out, outline_svg(curve, openings))
    for path in described:
        write_text(path, _description(out, openings))
    print(f"outline: {out}, {across:.3f} m wide, {along:.3f} m long, {len(curve)} points")
    print(f"look at: {picture}, the outline on top of the photo")
    for path in described:
        print(
            f"garment: {path}, two layers, open at {', '.join(openings)}; the SVG has these lines by name, to be edited"
        )
    for note in found.notes:
        print(f"note: {note}")


def to_metres(photo: Photo, width: float | None, ruler: str | None, sheet: str | None) -> np.ndarray:
    """Return the matrix from pixels to metres, shape (3, 3)."""
    from tatamu.garments.photo import homography

    if sheet is not None:
        return homography(_corners(sheet), *parse_size(sheet.split()[-1], "sheet"))
    if ruler is not None:
        *ends, length = ruler.split() or [""]
        if len(ends) != 2:
            raise InputError(f"ruler: must be two pixels X,Y and a length in metres, given {ruler!r}")
        start, end = (_pixel("ruler", pixel) for pixel in ends)
        apart, metres = float(np.linalg.norm(end - start)), _number("ruler", length)
    else:
        apart, metres = float(np.ptp(photo.outline[:, 0])), width or 0.0
    if not apart > 0.0:
        raise InputError("ruler: its two pixels must be different ones")
    if not 0.0 < metres < np.inf:
        raise InputError(f"{'width' if ruler is None else 'ruler'}: must be a length above zero, given {metres:g} m")
    return np.diag([metres / apart, metres / apart, 1.0])


def _corners(sheet: str) -> np.ndarray:
    """Return the corners of a sheet [pixels], shape (4, 2)."""
    corners = sheet.split()[:-1]
    if len(corners) != 4:
        raise InputError(f"sheet: must be four corners X,Y and WxH, given {sheet!r}")
    return np.array([_pixel("sheet", corner) for corner in corners])


def _pixel(option: str, text: str) -> np.ndarray:
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(f"{option}: must be pixels X,Y, given {text!r}")
    place = np.array([_number(option, part) for part in parts])
    if not (np.abs(place) <= FARTHEST).all():
        raise InputError(f"{option}: must be pixels from {-FARTHEST:g} to {FARTHEST:g}, given {text!r}")
    return place


def _number(option: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{option}: must be a number, given {text!r}")
    return value


def _description(outline: Path, openings: Mapping[str, np.ndarray]) -> str:
    """Return a garment file of a T-shirt with this outline."""
    import tomli_w

    table = {"name": outline.stem[:60], "kind": "tshirt", "outline": outline.name, "openings": list(openings)}
    return tomli_w.dumps({"garment": table})


def _overlay(photo: Photo, openings: Mapping[str, np.ndarray]) -> bytes:
    """Return the photo with the outline and its openings drawn on it, as a JPEG file."""
    import io

    from PIL import Image, ImageDraw

    image = Image.fromarray(photo.pixels)
    points = [tuple(p) for p in np.vstack([photo.outline, photo.outline[:2]])]
    wide = max(2, round(max(image.size) / 300))
    canvas = ImageDraw.Draw(image)
    canvas.line(points, "#ffffff", 2 * wide, joint="curve")
    canvas.line(points, "#d02090", wide, joint="curve")
    for name, numbers in openings.items():
        along = photo.outline[numbers]
        canvas.line([tuple(p) for p in along], "#ffffff", 4 * wide, joint="curve")
        canvas.line([tuple(p) for p in along], "#1f6fd0", 3 * wide, joint="curve")
        middle = tuple(along[[0, -1]].mean(axis=0))
        canvas.text(middle, name, "#1f6fd0", anchor="mm", font_size=8 * wide, stroke_width=wide, stroke_fill="#ffffff")
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=88)
    return buffer.getvalue()
