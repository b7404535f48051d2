"""Draws all fold plans for a garment, as a page or as a picture. There is one drawing for each plan."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
import shapely
from markupsafe import Markup
from PIL import Image, ImageDraw, ImageFont

from tatamu.folding.coverage import Part
from tatamu.folding.fold import ideal_folds
from tatamu.folding.plan import Plan
from tatamu.folding.plans import Proposal
from tatamu.garments import Garment
from tatamu.report.garment import FoldMark, diagram
from tatamu.show.drawing import Drawing
from tatamu.show.image import encoded
from tatamu.show.page import render
from tatamu.show.shapes import Polyline


def marks(garment: Garment, plan: Plan) -> list[FoldMark]:
    """Return the marks of all folds of a plan: fold lines and grasps, for a drawing of the flat garment.

    In later steps of the plan, the garment is already folded. The drawing nevertheless shows the flat garment. The
    grasps of later steps are therefore drawn at the positions of the grasped vertices on the flat garment.
    """
    flat = garment.vertices[:, :2]
    titles = [f"{number}. {step.title or 'fold'}" for number, step in enumerate(plan.steps, start=1)]
    names = titles if len(titles) > 1 else [plan.name]
    return [
        FoldMark(title, fold.line, fold.normal, flat[fold.left], flat[fold.right] if fold.hands == 2 else flat[:0])
        for title, fold in zip(names, ideal_folds(garment, plan), strict=True)
    ]


def drawings(garment: Garment, proposals: Sequence[Proposal]) -> list[Drawing]:
    """Return a drawing of each plan on the flat garment. Parts of the garment that no hand carries are shaded.

    Raises:
        InputError: If a plan cannot fold the garment.
    """
    drawn = []
    for proposal in proposals:
        drawing = diagram(garment, marks(garment, proposal.plan))
        for _, part in proposal.missed:
            drawing.add(*_shaded(garment, part))
        drawn.append(drawing)
    return drawn


def _shaded(garment: Garment, part: Part) -> list[Polyline]:
    """Return shaded regions that cover a part of the garment in a drawing."""
    inside = np.isin(garment.faces, part.vertices).all(axis=1)
    covered = shapely.union_all(shapely.polygons(garment.vertices[garment.faces[inside], :2]), grid_size=1e-6)
    regions = [each for each in shapely.get_parts(covered) if isinstance(each, shapely.Polygon)]
    return [Polyline(np.array(each.exterior.coords), width=0.0, fill="warm", opacity=0.5) for each in regions]


def page(garment: Garment, proposals: Sequence[Proposal]) -> str:
    """Return an HTML page with all plans, which opens without a network.

    Raises:
        InputError: If a plan cannot fold the garment.
    """
    plans = []
    for proposal, drawing in zip(proposals, drawings(garment, proposals), strict=True):
        warnings = [f"Step {number + 1}: no hand carries {part.text}" for number, part in proposal.missed]
        plans.append((proposal.plan, Markup(drawing.svg()), warnings))
    return render("report/candidates.html", title=garment.name, plans=plans)


def picture(garment: Garment, proposals: Sequence[Proposal]) -> bytes:
    """Return a picture of all plans side by side, as the bytes of a PNG file.

    Raises:
        InputError: If a plan cannot fold the garment.
    """
    images = [Image.open(io.BytesIO(drawing.png())) for drawing in drawings(garment, proposals)]
    columns = min(3, len(images))
    title = 40  # height of the line with a plan's name above its drawing [pixels]
    width, height = images[0].width, images[0].height + title
    rows = -(-len(images) // columns)
    sheet = Image.new("RGB", (width * columns, height * rows), "#fff")
    canvas = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(22)
    for number, (proposal, image) in enumerate(zip(proposals, images, strict=True)):
        left = width * (number % columns)
        top = height * (number // columns)
        sheet.paste(image, (left, top + title))
        name = proposal.plan.name + (" (not all is carried)" if proposal.missed else "")
        canvas.text((left + 16, top + 8), name, "#20242c", font)
    return encoded(sheet)
