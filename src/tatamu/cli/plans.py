"""The command `tatamu plans`, which lists fold plans for a garment, found from its outline."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tatamu.base.errors import InputError
from tatamu.base.size import parse_size
from tatamu.cli.app import app

if TYPE_CHECKING:
    from tatamu.folding.proposals import Proposal
    from tatamu.garments import Garment

SUFFIXES = (".html", ".png", ".toml")


@app.command()
def plans(
    garment: Annotated[str, typer.Argument(metavar="GARMENT", help="A name (`tatamu garments`) or a file.")],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="PATH",
            help="A page (.html) or a picture (.png) of all plans, a file of the best plan (.toml), or a folder for "
            "all of these.",
        ),
    ] = None,
    fold: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME|FILE.toml", help="Only this plan; may be given several times. auto: the best."),
    ] = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxL", help="Width x length in metres, such as 0.54x0.46.")
    ] = None,
    material: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="A material; default: the garment's own fabric.")
    ] = None,
    spacing: Annotated[float | None, typer.Option(help="Mesh spacing in metres.")] = None,
    scale: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            help="Metres per unit of the garment's file, such as 0.001; default: the unit that the file states.",
        ),
    ] = None,
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
    from tatamu.garments import make_garment
    from tatamu.simulation.material import load_material

    if out is not None and out.suffix and out.suffix.lower() not in SUFFIXES:
        raise InputError(f"--out: must be an .html, .png or .toml file or a folder, given {out}")
    if out is not None and out.suffix.lower() == ".toml" and len(fold or ()) > 1:
        raise InputError(f"--out: must be a page, a picture or a folder for {len(fold or ())} plans, given {out}")
    sides = None if size is None else parse_size(size)
    made = make_garment(garment, sides, load_material(material) if material else None, spacing, scale)
    found = chosen(made, fold or ())
    print(made.statement)
    for note in made.notes:
        print(f"note: {note}")
    for number, proposal in enumerate(found):
        _print(proposal, best=number == 0 and not fold)
    if out is not None:
        _write(made, found, out)


def _print(proposal: Proposal, best: bool) -> None:
    """Print a fold plan, its steps, and the parts of the garment that no hand carries."""
    plan = proposal.plan
    print(f"{plan.name}{' (the best)' if best else ''}")
    for number, step in enumerate(plan.steps, start=1):
        hands = "one hand" if step.hands == 1 else "two hands"
        print(f"  {number}. {step.title or 'fold'}: {hands} at {' and '.join(step.grasp)}")
    for number, part in proposal.missed:
        print(f"  in step {number + 1}, no hand carries {part.text}")


def _write(garment: Garment, found: list[Proposal], out: Path) -> None:
    """Write the page, the picture or the plan file that `--out` names, or a folder with all of them."""
    from tatamu.base.files import replacing, write_text
    from tatamu.report.candidates import page, picture

    kind = out.suffix.lower()
    targets = [out] if kind else [out / "plans.html", out / "plans.png"]
    for path in targets:
        if path.suffix.lower() == ".html":
            write_text(path, page(garment, found))
        elif path.suffix.lower() == ".png":
            drawn = picture(garment, found)
            with replacing(path) as temporary:
                temporary.write_bytes(drawn)
        else:
            write_text(path, found[0].plan.to_toml())
        print(f"written: {path}")
    for proposal in [] if kind else found:
        path = out / f"{proposal.plan.name}.toml"
        write_text(path, proposal.plan.to_toml())
        print(f"written: {path}")
