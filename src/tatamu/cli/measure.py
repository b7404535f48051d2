"""The command `tatamu measure`, which explains how to measure cloth with a ruler, a kitchen scale and a board."""

from __future__ import annotations

from pathlib import Path

import typer

from tatamu.base.errors import InputError


def measure(
    template: str | None = typer.Option(
        None, metavar="GARMENT", help="Write a form for the readings of this garment (towel, tshirt, trousers, ...)."
    ),
    out: Path = typer.Option(Path("measurements.toml"), metavar="FILE.toml", help="File name of the form."),
    drape: Path | None = typer.Option(
        None,
        metavar="PHOTO",
        help="Photo from above of a cloth disc that hangs over a plate; the drape is read from this photo.",
    ),
    disc: float | None = typer.Option(None, help="With --drape: diameter of the cloth disc in metres."),
    plate: float | None = typer.Option(None, help="With --drape: diameter of the plate in metres."),
    ruler: str | None = typer.Option(
        None, metavar="'X,Y X,Y LENGTH'", help="With --drape: two pixels and the distance between them in metres."
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
    from tatamu.base.files import in_shell, write_text
    from tatamu.calibration.measurements import instructions
    from tatamu.calibration.measurements import template as text

    if template is None:
        print(instructions(), end="")
        return
    content = text(template)
    if out.exists():
        raise InputError(f"{out}: must be a new file, but already exists; give another name with --out")
    write_text(out, content)
    print(
        f"{out}: fill in the readings as `tatamu measure` explains, then run `tatamu calibrate {in_shell(out)} --out "
        "MATERIAL.toml`"
    )


def _read_drape(photo: Path, disc: float | None, plate: float | None, ruler: str | None) -> None:
    import numpy as np

    from tatamu.calibration.instruments.outline import PlanOutline, centroid
    from tatamu.cli.pixels import to_metres
    from tatamu.garments.photo import find_outline, straightened

    if disc is None or plate is None or ruler is None:
        raise InputError("--drape: must be given together with --disc, --plate and --ruler")
    if not 0.0 < plate < disc < np.inf:
        raise InputError(f"--plate: must be above 0 m and less than --disc ({disc:g} m), given {plate:g} m")
    found = find_outline(photo)
    curve = straightened(found.outline, to_metres(found, None, ruler, None))
    outline = PlanOutline.of_curve(curve, centroid(curve))
    coefficient = outline.drape_coefficient(0.5 * disc, 0.5 * plate)
    if not 0.0 < coefficient < 1.0:
        raise InputError(
            "--drape: the cloth in the photo must cover more than the plate and less than the disc, but "
            f"covers {1e4 * outline.area:.0f} cm²; check that --disc, --plate and --ruler are in metres"
        )
    print(f"drape_coefficient = [{coefficient:.3f}]")
    print(f"nodes = [{outline.nodes}]")
