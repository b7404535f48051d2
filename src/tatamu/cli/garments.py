"""The commands `tatamu garments`, `plans` and `show`, which list garments, and draw them and their fold plans."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tatamu.base.errors import InputError
from tatamu.base.files import write_bytes, write_text
from tatamu.base.size import parse_size

if TYPE_CHECKING:
    from tatamu.folding.plans import Proposal
    from tatamu.garments import Garment
    from tatamu.report.garment import FoldMark

GarmentArgument = Annotated[
    str, typer.Argument(metavar="GARMENT", help="Name of a garment (see `tatamu garments`), or the file of a garment.")
]
SizeOption = Annotated[str | None, typer.Option(metavar="WxL", help="Width x length in metres, such as 0.54x0.46.")]
MaterialOption = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.toml", help="Material file, or a preset such as denim; default: the garment's own fabric."
    ),
]
SpacingOption = Annotated[float | None, typer.Option(help="Mesh spacing in metres.")]
ScaleOption = Annotated[
    float | None,
    typer.Option(
        metavar="M",
        help="Length of one unit in the garment's file [m], such as 0.001; default: as stated in the file.",
    ),
]


def garments() -> None:
    """List the garments that have a name, with their default size and fabric.

    Commands also accept a garment from a file. The file is an outline (.svg, .dxf), a mesh (.obj, .ply, .stl, .glb) or
    a garment file (.toml), which docs/reference/garment-file.md describes. `tatamu show GARMENT` draws a garment.

    Example: `tatamu garments`
    """
    from rich.console import Console

    from tatamu.garments import DESCRIPTIONS, make_garment
    from tatamu.show.quantity import Table, terminal
    from tatamu.simulation.material import preset_names
    from tatamu.simulation.presets import load_preset

    rows = []
    presets = {each: load_preset(each).material for each in preset_names()}
    for name, what in DESCRIPTIONS.items():
        garment = make_garment(name)
        fabric = next(each for each, material in presets.items() if material == garment.material)
        size = "{:g}x{:g}".format(*garment.size)
        rows.append((name, what, size, str(garment.layers), str(len(garment.vertices)), fabric))
    head = ("garment", "what", "width x length", "layers", "vertices", "fabric")
    Console().print(terminal(Table(head, rows)))
    print(
        "\nOr use your own garment: an outline (.svg, .dxf), a mesh (.obj, .ply, .stl, .glb) or a garment file (.toml)."
    )


def plans(
    garment: GarmentArgument,
    out: Path | None = typer.Option(
        None,
        metavar="PATH",
        help="File to write: a page (.html) or a picture (.png) of all plans, or the best plan (.toml). A folder gets "
        "all three.",
    ),
    fold: list[str] | None = typer.Option(
        None,
        metavar="NAME|FILE.toml",
        help="Fold plan to show (repeatable), or auto for the best; default: all plans.",
    ),
    size: SizeOption = None,
    material: MaterialOption = None,
    spacing: SpacingOption = None,
    scale: ScaleOption = None,
) -> None:
    """List the fold plans for a garment, from the best to the worst. Nothing is simulated.

    A plan first folds in the parts that stick out of the body of the garment, such as sleeves or a hood. Then it folds
    the garment in half. If the hands of a plan leave a part behind, the plan comes last, with the name of the part.

    Examples:
    `tatamu plans hoodie.toml`

    `tatamu plans hoodie.toml --out plans.html`

    `tatamu plans hoodie.toml --fold sides-half --out my-fold.toml`

    `tatamu learn hoodie.toml --fold my-fold.toml --out runs/hoodie`

    `tatamu learn hoodie.toml --fold auto --out runs/hoodie` (uses the best plan)
    """
    from tatamu.folding.advice import chosen

    if out is not None and out.suffix and out.suffix.lower() not in (".html", ".png", ".toml"):
        raise InputError(f"--out: must be an .html, .png or .toml file or a folder, given {out}")
    if out is not None and out.suffix.lower() == ".toml" and len(fold or ()) > 1:
        raise InputError(
            f"--out: a .toml file can contain only one plan, given {out} for {len(fold or ())} plans; give an .html "
            "file, a .png file or a folder"
        )
    made = _made(garment, size, material, spacing, scale)
    found = chosen(made, fold or ())
    print(made.statement)
    for note in made.notes:
        print(f"note: {note}")
    for place, proposal in enumerate(found):
        print(f"{proposal.plan.name}{' (the best)' if place == 0 and not fold else ''}")
        for number, step in enumerate(proposal.plan.steps, start=1):
            hands = "one hand" if step.hands == 1 else "two hands"
            print(f"  {number}. {step.title or 'fold'}: {hands} at {' and '.join(step.grasp)}")
        for number, part in proposal.missed:
            print(f"  step {number + 1}: no hand carries {part.text}")
    if out is not None:
        _write(made, found, out)


def _write(garment: Garment, found: list[Proposal], out: Path) -> None:
    """Write the page, the picture or the plan file that `--out` names, or a folder with all of them."""
    from tatamu.report.candidates import page, picture

    whole = not out.suffix
    for path in [out / "plans.html", out / "plans.png"] if whole else [out]:
        if path.suffix.lower() == ".html":
            write_text(path, page(garment, found))
        elif path.suffix.lower() == ".png":
            write_bytes(path, picture(garment, found))
        else:
            write_text(path, found[0].plan.to_toml())
        print(f"written: {path}")
    for proposal in found if whole else ():
        path = out / f"{proposal.plan.name}.toml"
        write_text(path, proposal.plan.to_toml())
        print(f"written: {path}")


def show(
    garment: GarmentArgument,
    out: Path | None = typer.Option(
        None, metavar="PATH", help="Write a page (.html), a picture (.png), or both into a folder; default: NAME.html."
    ),
    size: SizeOption = None,
    scale: ScaleOption = None,
    material: MaterialOption = None,
    spacing: SpacingOption = None,
    fold: str | None = typer.Option(
        None,
        "--fold",
        "--plan",
        metavar="NAME|FILE.toml",
        help="Also draw a fold plan: its fold lines, moving sides and grasp candidates.",
    ),
) -> None:
    """Draw a flat garment with its seams, its openings and the names of its edges.

    Examples:
    `tatamu show tshirt --fold half --out tshirt.html`

    `tatamu show tshirt --plan my-fold.toml --out plan.png`

    `tatamu show shirt.svg --out pictures`
    """
    from tatamu.report.garment import diagram, facts, page

    made = _made(garment, size, material, spacing, scale)
    print(made.statement)
    folds = _marks(made, fold) if fold else []
    for path in _targets(out, Path(garment).stem):
        if path.suffix.lower() == ".html":
            write_text(path, page(made, folds))
        else:
            write_bytes(path, diagram(made, folds).png())
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


def _made(garment: str, size: str | None, material: Path | None, spacing: float | None, scale: float | None) -> Garment:
    """Return the garment that the options describe."""
    from tatamu.garments import make_garment
    from tatamu.simulation.material import load_material

    sides = None if size is None else parse_size(size)
    return make_garment(garment, sides, load_material(material) if material else None, spacing, scale)
