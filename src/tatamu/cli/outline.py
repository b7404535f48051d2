"""The command `tatamu outline`, which finds the outline of a flat garment in a photo."""

from __future__ import annotations

from pathlib import Path

import typer

from tatamu.base.errors import InputError
from tatamu.cli.photographs import JoinOption


def outline(
    photo: Path = typer.Argument(
        ..., metavar="PHOTO", help="Photo from above, with the hem at the bottom, and the table visible on all sides."
    ),
    out: Path = typer.Option(..., metavar="OUTLINE.svg", help="Outline file to write."),
    width: float | None = typer.Option(None, help="Largest width of the garment, in metres."),
    ruler: str | None = typer.Option(
        None, metavar="'X,Y X,Y LENGTH'", help="Two pixels and the distance between them in metres."
    ),
    sheet: str | None = typer.Option(
        None,
        metavar="'X,Y X,Y X,Y X,Y WxH'",
        help="Find scale and perspective from a sheet of paper on the table: its corners, clockwise from the top left, "
        "and its size in metres.",
    ),
    garment: str | None = typer.Option(
        None,
        metavar="NAME",
        help="tshirt: also find the hem, sleeves and neck, and write a garment file with two layers.",
    ),
    join: JoinOption = False,
) -> None:
    """Find the outline of a garment in a photo, and draw the outline on the photo for you to check.

    Examples:
    `tatamu outline shirt.jpg --width 0.52 --out shirt.svg`

    `tatamu outline shirt.jpg --sheet '80,90 700,84 706,520 76,524 0.297x0.210' --out shirt.svg`

    `tatamu outline shirt.jpg --width 0.52 --garment tshirt --out shirt.svg`

    Then run `tatamu show shirt.svg`. A garment file can name the open parts of the outline
    (docs/reference/garment-file.md). With `--garment`, the command writes this file too, here shirt.toml. Then run
    `tatamu show shirt.toml --fold shop`.
    """
    import tomli_w

    from tatamu.base.files import check_targets, write_bytes, write_text
    from tatamu.cli.pixels import corners_of, drawn_over, to_metres
    from tatamu.garments.garment import check_size
    from tatamu.garments.landmarks import tshirt_openings
    from tatamu.garments.photo import find_outline, outline_svg, straightened

    given = [value for value in (width, ruler, sheet) if value is not None]
    if len(given) != 1:
        raise InputError(f"--width, --ruler, --sheet: exactly one is needed, given {len(given) or 'none'}")
    if out.suffix.lower() != ".svg":
        raise InputError(f"--out: must be an .svg file, given {out}")
    if garment not in (None, "tshirt"):
        raise InputError(
            f"--garment: must be tshirt, given {garment!r}; for another garment, name the openings in a garment file"
        )
    picture = out.with_name(f"{out.stem}-on-photo.jpg")
    described = [out.with_suffix(".toml")] if garment else []
    check_targets([out, picture, *described], [photo])
    found = find_outline(photo, join, None if sheet is None else corners_of(sheet).mean(axis=0)[None])
    curve = straightened(found.outline, to_metres(found, width, ruler, sheet))
    across, along = curve.max(axis=0) - curve.min(axis=0)
    try:
        check_size((across, along))
    except InputError as error:
        raise InputError(f"{error}; check that all lengths are in metres") from None
    openings = tshirt_openings(curve) if garment else {}
    write_bytes(picture, drawn_over(found, openings))
    write_text(out, outline_svg(curve, openings))
    for path in described:
        table = {"name": out.stem[:60], "kind": "tshirt", "outline": out.name, "openings": list(openings)}
        write_text(path, tomli_w.dumps({"garment": table}))
    print(f"outline: {out}, {across:.3f} m wide, {along:.3f} m long, {len(curve)} points")
    print(f"check the outline in {picture}")
    for path in described:
        advice = "to change the openings, edit the lines with these names in the .svg file"
        print(f"garment: {path}, two layers, open at {', '.join(openings)}; {advice}")
    for note in found.notes:
        print(f"note: {note}")
