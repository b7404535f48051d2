"""Fold plans that a garment can be folded by, drawn one by one, as a page and as a picture."""

from __future__ import annotations

import io
from collections.abc import Sequence
from importlib.resources import files

from tatamu import __version__
from tatamu.folding.fold import ideal_folds
from tatamu.folding.plan import Plan
from tatamu.folding.proposals import Proposal
from tatamu.garments import Garment
from tatamu.report.diagram import Diagram
from tatamu.report.garment import FoldMark, diagram
from tatamu.report.markup import text
from tatamu.report.palette import css

COLUMNS = 3
"""A picture has so many plans side by side."""
TITLE = 40
"""Height of a plan's name over its drawing [pixels]."""


def marks(garment: Garment, plan: Plan) -> list[FoldMark]:
    """Every fold of a plan on the flat garment; the places of later grasps are those that they have there."""
    flat = garment.vertices[:, :2]
    titles = [f"{number}. {step.title}" for number, step in enumerate(plan.steps, start=1)]
    names = titles if len(titles) > 1 else [plan.name]
    return [
        FoldMark(title, fold.line, fold.normal, flat[fold.left], flat[fold.right] if fold.hands == 2 else flat[:0])
        for title, fold in zip(names, ideal_folds(garment, plan), strict=True)
    ]


def drawings(garment: Garment, proposals: Sequence[Proposal]) -> list[Diagram]:
    """A drawing of each plan.

    Raises:
        InputError: The garment cannot be folded so.
    """
    return [diagram(garment, marks(garment, proposal.plan)) for proposal in proposals]


def page(garment: Garment, proposals: Sequence[Proposal]) -> str:
    """All plans as one HTML page that opens offline, the first marked as the best.

    Raises:
        InputError: The garment cannot be folded so.
    """
    style = (files("tatamu.report") / "style.css").read_text(encoding="utf-8")
    drawn = drawings(garment, proposals)
    cards = "".join(
        f"<h2>{text(proposal.plan.name)}</h2><section class='card'><figure>{drawing.svg()}"
        f"<figcaption>{text(proposal.text)}</figcaption></figure>{_left_behind(proposal)}</section>"
        for proposal, drawing in zip(proposals, drawn, strict=True)
    )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{text(garment.name)}: fold plans</title><style>:root{{{css()}}}{style}"
        "figure svg{max-height:70vh;border-radius:10px}</style></head><body>"
        f'<header><p class="brand">tatamu <span>fold plans</span></p><h1>{text(garment.name)}</h1></header>'
        f"<main>{cards}</main><footer><p class='about'>tatamu {__version__}</p></footer></body></html>\n"
    )


def _left_behind(proposal: Proposal) -> str:
    lines = "".join(
        f"<li>Step {number + 1}: no hand carries {text(part.text)}</li>" for number, part in proposal.missed
    )
    return f'<ul class="warnings">{lines}</ul>' if lines else ""


def picture(garment: Garment, proposals: Sequence[Proposal]) -> bytes:
    """All plans side by side, as the bytes of a PNG file.

    Raises:
        InputError: The garment cannot be folded so.
    """
    from PIL import Image, ImageDraw, ImageFont

    images = [Image.open(io.BytesIO(drawing.png())) for drawing in drawings(garment, proposals)]
    columns = min(COLUMNS, len(images))
    width, height = images[0].width, images[0].height + TITLE
    rows = -(-len(images) // columns)
    sheet = Image.new("RGB", (width * columns, height * rows), "#fff")
    canvas = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(22)
    for number, (proposal, image) in enumerate(zip(proposals, images, strict=True)):
        corner = (width * (number % columns), height * (number // columns))
        sheet.paste(image, (corner[0], corner[1] + TITLE))
        name = proposal.plan.name + (" (not all is carried)" if proposal.missed else "")
        canvas.text((corner[0] + 16, corner[1] + 8), name, "#20242c", font)
    buffer = io.BytesIO()
    sheet.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()
