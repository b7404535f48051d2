"""Draws a flat garment from above: its mesh, seams, openings, grasp candidates and fold lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from markupsafe import Markup

from tatamu.garments import Garment
from tatamu.show.drawing import FROM_ABOVE, Drawing
from tatamu.show.material import properties
from tatamu.show.page import render
from tatamu.show.quantity import Table, number
from tatamu.show.shapes import Dot, Label, Polyline, Segments, Shape
from tatamu.simulation.mesh.topology import Topology, areas

SEAM = "accent"
OPENING = "warm"


@dataclass(frozen=True)
class FoldMark:
    """The marks of a fold in a drawing: the fold line and the grasp candidates."""

    name: str
    line: np.ndarray
    """Two points that define the fold line [m], shape (2, 2)."""
    towards: np.ndarray
    """Unit vector from the moving side to the side that stays, shape (2,)."""
    left: np.ndarray
    """The k positions at which the left hand may grasp [m], shape (k, 2)."""
    right: np.ndarray
    """The k positions at which the right hand may grasp [m], shape (k, 2)."""


def diagram(garment: Garment, folds: Sequence[FoldMark] = ()) -> Drawing:
    """Draw a garment with the marks of folds."""
    plan = garment.vertices[:, :2]
    low, high = plan.min(axis=0), plan.max(axis=0)
    margin = 0.22 * float((high - low).max())
    low, high = low - margin, high + margin
    words = f"{garment.name} from above, {len(garment.vertices)} vertices in {garment.layers} layers"
    tall = 760  # [pixels]
    drawing = Drawing(low, high, tall / float(high[0] - low[0]), FROM_ABOVE, words=words)
    drawing.add(*_cloth(garment), *_edges(garment))
    shown = [replace(fold, line=_within(fold.line, plan)) for fold in folds]
    for fold in shown:
        _draw_fold(drawing, fold, margin, [other for other in shown if other is not fold])
    drawing.shapes.sort(key=lambda shape: isinstance(shape, Label))  # draws names last, over all lines
    _draw_scale(drawing)
    return drawing


def _cloth(garment: Garment) -> list[Shape]:
    """Return the region that the garment covers, and the triangles of its upper side."""
    plan = garment.vertices[:, :2]
    triangles = shapely.polygons(plan[garment.faces])
    covered = shapely.get_parts(shapely.union_all(triangles[shapely.area(triangles) > 0.0], grid_size=1e-6))
    a, b, c = (plan[garment.faces[:, k]] for k in range(3))
    up = (b - a)[:, 0] * (c - a)[:, 1] > (b - a)[:, 1] * (c - a)[:, 0]
    shapes: list[Shape] = []
    for part in covered:
        shapes.append(Polyline(np.array(part.exterior.coords), width=0.0, fill="cloth"))
        shapes += [Polyline(np.array(hole.coords), width=0.0, fill="card") for hole in part.interiors]
    return [*shapes, Segments(plan[Topology(garment.faces[up]).edges], "mesh")]


def _edges(garment: Garment) -> list[Shape]:
    """Return the shapes that draw the named sides of a garment.

    Seams are solid and openings are dashed. Names are outside the garment, or inside if there is no space outside.
    """
    plan = garment.vertices[:, :2]
    places = shapely.points(plan)
    shapes: list[Shape] = []
    for name, path in garment.edges.items():
        points = plan[path]
        opened = name in garment.openings
        colour = OPENING if opened else SEAM
        shapes.append(Polyline(points, colour, 2.5, 5.0 if opened else 0.0))
        middle = len(points) // 2
        along = points[min(middle + 1, len(points) - 1)] - points[max(middle - 1, 0)]
        out = np.array([along[1], -along[0]]) / (np.linalg.norm(along) + 1e-12)
        word = 0.013 * len(name) * float(np.ptp(plan, axis=0).max())  # approximate length of the written name
        beside = shapely.LineString([points[middle] + 0.2 * word * out, points[middle] + word * out])
        if (shapely.distance(places, beside) >= 0.1 * word).all():
            shapes.append(Label(points[middle], name, out, colour))
        elif abs(out[1]) > 0.8:
            shapes.append(Label(points[middle], name, -out, colour))
        else:
            shapes.append(Label(points[middle] - 0.25 * word * out, name, 0.0 * out, colour))
    return shapes


def _within(line: np.ndarray, plan: np.ndarray) -> np.ndarray:
    """Return the part of a fold line over the garment; a plan's line may reach far beyond."""
    part = shapely.clip_by_rect(shapely.LineString(line), *plan.min(axis=0), *plan.max(axis=0))
    return line if part.is_empty else shapely.get_coordinates(part)[[0, -1]]


def _draw_fold(drawing: Drawing, fold: FoldMark, margin: float, others: Sequence[FoldMark]) -> None:
    """Draw the fold line, an arrow over it, and the grasp candidates."""
    start, end = fold.line
    along = (end - start) / np.linalg.norm(end - start)
    head, reach = 0.12 * margin, 0.7 * margin
    arrow = _arrow(fold, 0.35 * margin, shapely.MultiLineString([other.line for other in others]), 2.0 * head)
    drawing.line([start - reach * along, end + reach * along], "target", 2.0, dash=8.0)
    drawing.arrow(arrow, "target", 2.0, head=head)
    drawing.label(end + reach * along, fold.name, "target", -fold.towards)
    drawing.add(*(Dot(place, "left", 3.0) for place in fold.left))
    drawing.add(*(Dot(place, "right", 3.0) for place in fold.right))


def _arrow(fold: FoldMark, arm: float, others: shapely.Geometry, clear: float) -> np.ndarray:
    """Return the tail and the tip of a fold's arrow.

    The arrow is as near to the middle of the fold line as possible without touching other lines.
    """
    start, end = fold.line
    arms = np.outer([-arm, arm], fold.towards)
    parts = (0.5, 0.45, 0.55, 0.4, 0.6, 0.35, 0.65, 0.3, 0.7, 0.25, 0.75, 0.2, 0.8)  # from the best to the worst
    arrows = [start + part * (end - start) + arms for part in parts]
    free = (arrow for arrow in arrows if others.is_empty or others.distance(shapely.LineString(arrow)) >= clear)
    return next(free, arrows[0])


def _draw_scale(drawing: Drawing) -> None:
    """Draw a scale bar of ten centimetres in one corner, and the axes in another corner."""
    low, high = drawing.low, drawing.high
    gap = 0.06 * float(high[0] - low[0])
    drawing.ruler([low[0] + gap, high[1] - gap - 0.1])
    corner = np.array([low[0] + gap, low[1] + 1.6 * gap])
    ahead, aside = corner + gap * np.eye(2)
    drawing.line([ahead, corner, aside], "muted")
    drawing.label(ahead, "x", "muted", (1.0, 0.0))
    drawing.label(aside, "y", "muted", (0.0, 1.0))


def facts(garment: Garment) -> list[tuple[str, str]]:
    """Return facts about a garment as pairs of a name and a value, such as its size."""
    rest = garment.unstrained
    mass = float(areas(rest, garment.faces).sum()) * garment.material.areal_density
    width, length = garment.size
    cells = garment.spacing / garment.material.bending_length
    return [
        ("size", f"{width:.3f} m wide, {length:.3f} m long"),
        *([("unit", garment.reading)] if garment.reading else []),
        ("layers", str(garment.layers)),
        ("mesh", f"{len(garment.vertices)} vertices, {len(garment.faces)} triangles"),
        ("spacing", f"{1e3 * garment.spacing:.1f} mm, {cells:.2f} bending lengths"),
        ("mass", f"{1e3 * mass:.0f} g"),
        ("openings", ", ".join(garment.openings) or "none"),
    ]


def page(garment: Garment, folds: Sequence[FoldMark] = ()) -> str:
    """Return an HTML page with the drawing and all facts of a garment, which opens without a network."""
    legend = [(SEAM, "seam"), (OPENING, "open edge")]
    if folds:
        legend += [("target", "fold line"), ("left", "grasps of the left hand"), ("right", "grasps of the right hand")]
    return render(
        "report/garment.html",
        title=garment.name,
        garment=garment,
        drawing=Markup(diagram(garment, folds).svg()),
        legend=legend,
        facts=facts(garment),
        edges=Table(("edge", "", "length [mm]", "vertices"), _named_edges(garment)),
        material=[(each.name, str(each)) for each in properties(garment.material)],
    )


def _named_edges(garment: Garment) -> list[tuple[str, str, str, str]]:
    """Return the name of each edge, whether it is open or sewn, its length and its number of vertices."""
    rows = []
    for name, path in garment.edges.items():
        length = np.linalg.norm(np.diff(garment.vertices[path, :2], axis=0), axis=1).sum()
        rows.append((name, "open" if name in garment.openings else "sewn", number(length, "mm", ".0f"), str(len(path))))
    return rows
