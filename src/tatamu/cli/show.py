"""The command `tatamu show`, which draws a flat garment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tatamu.base.errors import InputError
from tatamu.base.size import parse_size
from tatamu.cli.app import app

if TYPE_CHECKING:
    from tatamu.garments import Garment
    from tatamu.report.garment import FoldMark


@app.command()
def show(
    garment: Annotated[str, typer.Argument(metavar="GARMENT", help="A name (`tatamu garments`) or a file.")],
    out: Annotated[
        Path | None,
        typer.Option(metavar="PATH", help="A page (.html), a picture (.png) or a folder for both; default: NAME.html."),
    ] = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxL", help="Width x length in metres, such as 0.54x0.46.")
    ] = None,
    scale: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            help="Metres per unit of the garment's file, such as 0.001; default: the unit that the file states.",
        ),
    ] = None,
    material: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="A material; default: the garment's own fabric.")
    ] = None,
    spacing: Annotated[float | None, typer.Option(help="Mesh spacing in metres.")] = None,
    fold: Annotated[
        str | None,
        typer.Option(
            "--fold",
            "--plan",
            metavar="NAME|FILE.toml",
            help="Also draw a fold plan: its fold lines, the moving sides, and the grasp candidates.",
        ),
    ] = None,
) -> None:
    """Draw a flat garment with its seams, its openings and the names of its edges.

    Examples:
    `tatamu show tshirt --fold half --out tshirt.html`

    `tatamu show tshirt --plan my-fold.toml --out plan.png`

    `tatamu show shirt.svg --out pictures`
    """
    from tatamu.base.files import replacing, write_text
    from tatamu.garments import make_garment
    from tatamu.report.garment import diagram, facts, page
    from tatamu.simulation.material import load_material

    sides = None if size is None else parse_size(size)
    made = make_garment(garment, sides, load_material(material) if material else None, spacing, scale)
    print(made.statement)
    folds = _marks(made, fold) if fold else []
    for path in _targets(out, Path(garment).stem):
        if path.suffix.lower() == ".html":
            write_text(path, page(made, folds))
        else:
            with replacing(path) as temporary:
                temporary.write_bytes(diagram(made, folds).png())
        print(f"picture: {path}")
    for name, value in facts(made):
        print(f"{name + ':':<10} {value}")
    for note in made.notes:
        print(f"note: {note}")


def _targets(out: Path | None, name: str) -> list[Path]:
    """Return the paths of the files to write: a page, a picture or both."""
    if out is None:
        return [Path(f"{name}.html")]
    if out.suffix.lower() in (".html", ".png"):
        return [out]
    if out.suffix:
        raise InputError(f"--out: must be an .html file, a .png file or a folder, given {out}")
    return [out / f"{name}.html", out / f"{name}.png"]


def _marks(garment: Garment, name: str) -> list[FoldMark]:
    """Return the marks of all folds of a plan (fold lines and grasps), for a drawing of the flat garment."""
    from tatamu.folding.plans import make_plan
    from tatamu.report.candidates import marks

    plan = make_plan(name, garment)
    try:
        return marks(garment, plan)
    except InputError as error:
        raise InputError(f"{name}: {error}" if name.endswith(".toml") else str(error)) from None
