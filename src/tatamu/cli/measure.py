"""The command `tatamu measure`, which explains how to measure cloth with a ruler, a kitchen scale and a board."""

from __future__ import annotations

from pathlib import Path

import typer

from tatamu.base.errors import InputError


def measure(
    template: str | None = typer.Option(
        None, metavar="GARMENT", help="Write a file to fill in: towel, tshirt, trousers, ..."
    ),
    out: Path = typer.Option(Path("measurements.toml"), metavar="FILE.toml", help="File of the template."),
    drape: Path | None = typer.Option(None, metavar="PHOTO", help="Read a photo of a disc over a plate, from above."),
    disc: float | None = typer.Option(None, help="With --drape: diameter of the cloth in metres."),
    plate: float | None = typer.Option(None, help="With --drape: diameter of the plate in metres."),
    ruler: str | None = typer.Option(
        None, metavar="'X,Y X,Y LENGTH'", help="With --drape: two pixels, and the metres between them."
    ),
) -> None:
    """Print how to measure a garment, write a file for the readings, or read a photo of a drape.

    Examples:
    `tatamu measure`

    `tatamu measure --template towel`

    `tatamu measure --template tshirt --out my-shirt.toml`

    `tatamu measure --drape drape.jpg --disc 0.30 --plate 0.18 --ruler '120,900 1120,900 0.30'`
    """
    if drape is not None:
        _read_drape(drape, disc, plate, ruler)
        return
    from tatamu.base.files import write_text
    from tatamu.calibration.measurements import instructions
    from tatamu.calibration.measurements import template as text

    if template is None:
        print(instructions(), end="")
        return
    content = text(template)
    if out.exists():
        raise InputError(f"{out}: exists; remove the file, or give another name with --out")
    write_text(out, content)
    print(f"{out}: fill in the readings, then `tatamu calibrate {out} --out MATERIAL.toml`; `tatamu measure` says how")


def _read_drape(photo: Path, disc: float | None, plate: float | None, ruler: str | None) -> None:
    import numpy as np

    from tatamu.calibration.instruments.outline import PlanOutline, centroid
    from tatamu.cli.pixels import to_metres
    from tatamu.garments.photo import find_outline, straightened

    if disc is None or plate is None or ruler is None:
        raise InputError("--drape: must be given with --disc, --plate and --ruler")
    if not 0.0 < plate < disc < np.inf:
        raise InputError(f"plate: must be above zero and smaller than disc ({disc:g} m), given {plate:g} m")
    found = find_outline(photo)
    curve = straightened(found.outline, to_metres(found, None, ruler, None))
    outline = PlanOutline.of_curve(curve, centroid(curve))
    coefficient = outline.drape_coefficient(0.5 * disc, 0.5 * plate)
    if not 0.0 < coefficient < 1.0:
        raise InputError(
            "drape: the outline must be larger than the plate and smaller than the disc, given "
            f"{1e4 * outline.area:.0f} cm²; are disc, plate and ruler in metres, and does the photo show nothing but "
            "cloth and table?"
        )
    print(f"drape_coefficient = [{coefficient:.3f}]")
    print(f"nodes = [{outline.nodes}]")
