"""A garment laid flat, drawn from above: mesh, seams, openings, grasp candidates and fold lines; and a page of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np
import shapely

from tatamu import __version__
from tatamu.garments import Garment
from tatamu.report.diagram import Diagram, Dot, Label, Line, Segments, Shape
from tatamu.report.markup import rows, table, text
from tatamu.report.palette import LEFT, RIGHT, TARGET, css
from tatamu.topology import Topology, areas

CLOTH, MESH, SEAM, OPENING, FAINT = "#dfe6f4", "#b9c6e0", "#2b3f74", "#d07a31", "#666d7a"
MARGIN = 0.22
"""White around the garment, as part of its longer side."""
ALONG = (0.5, 0.45, 0.55, 0.4, 0.6, 0.35, 0.65, 0.3, 0.7, 0.25, 0.75, 0.2, 0.8)
"""Parts of a fold line over which its arrow may lie, the best first."""


@dataclass(frozen=True)
class FoldMark:
    """What to draw of a fold."""

    name: str
    line: np.ndarray
    """Two points of the fold line [m], shape (2, 2)."""
    towards: np.ndarray
    """Unit vector from the moving side to the side that stays, shape (2,)."""
    left: np.ndarray
    """Grasp candidates of the left hand [m], shape (k, 2)."""
    right: np.ndarray
    """Grasp candidates of the right hand [m], shape (k, 2)."""


def diagram(garment: Garment, folds: Sequence[FoldMark] = ()) -> Diagram:
    """Draw a garment with the folds that it is handed."""
    plan = garment.vertices[:, :2]
    low, high = plan.min(axis=0), plan.max(axis=0)
    margin = MARGIN * float((high - low).max())
    shapes: list[Shape] = [*_cloth(garment), *_edges(garment)]
    for fold in folds:
        shapes += _fold(fold, margin, [other for other in folds if other is not fold])
    shapes.sort(key=lambda shape: isinstance(shape, Label))  # no line strikes a name through
    low, high = low - margin, high + margin
    words = f"{garment.name} from above, {len(garment.vertices)} vertices in {garment.layers} layers"
    return Diagram((*shapes, *_ruler(low, high)), low, high, words=words)


def _cloth(garment: Garment) -> list[Shape]:
    """The region that the garment covers, and the triangles of its upper side."""
    plan = garment.vertices[:, :2]
    triangles = shapely.polygons(plan[garment.faces])
    covered = shapely.get_parts(shapely.union_all(triangles[shapely.area(triangles) > 0.0], grid_size=1e-6))
    a, b, c = (plan[garment.faces[:, k]] for k in range(3))
    up = (b - a)[:, 0] * (c - a)[:, 1] > (b - a)[:, 1] * (c - a)[:, 0]
    shapes: list[Shape] = []
    for part in covered:
        shapes.append(Line(np.array(part.exterior.coords), width=0.0, fill=CLOTH))
        shapes += [Line(np.array(hole.coords), width=0.0, fill="#ffffff") for hole in part.interiors]
    return [*shapes, Segments(plan[Topology(garment.faces[up]).edges], MESH)]


def _edges(garment: Garment) -> list[Shape]:
    """Every named side: seams drawn through, openings dashed; its name outside, or inside for want of room."""
    plan = garment.vertices[:, :2]
    places = shapely.points(plan)
    shapes: list[Shape] = []
    for name, path in garment.edges.items():
        points, opened = plan[path], name in garment.openings
        colour = OPENING if opened else SEAM
        shapes.append(Line(points, colour, 2.5, 5.0 if opened else 0.0))
        middle = len(points) // 2
        way = points[min(middle + 1, len(points) - 1)] - points[max(middle - 1, 0)]
        out = np.array([way[1], -way[0]]) / (np.linalg.norm(way) + 1e-12)
        word = 0.013 * len(name) * float(np.ptp(plan, axis=0).max())  # about as long as it will be written
        beside = shapely.LineString([points[middle] + 0.2 * word * out, points[middle] + word * out])
        if (shapely.distance(places, beside) >= 0.1 * word).all():
            shapes.append(Label(points[middle], name, out, colour))
        elif abs(out[1]) > 0.8:
            shapes.append(Label(points[middle], name, -out, colour))
        else:
            shapes.append(Label(points[middle] - 0.25 * word * out, name, 0.0 * out, colour))
    return shapes


def _fold(fold: FoldMark, margin: float, others: Sequence[FoldMark]) -> list[Shape]:
    """The line, an arrow over it, and the places where the hands may grasp."""
    start, end = fold.line
    along = (end - start) / np.linalg.norm(end - start)
    arm, head = 0.35 * margin, 0.12 * margin
    tail, tip = _arrow(fold, arm, shapely.MultiLineString([other.line for other in others]), 2.0 * head)
    barbs = [tip - head * (fold.towards + side * along) for side in (1, -1)]
    reach = 0.7 * margin
    shapes: list[Shape] = [
        Line(np.array([start - reach * along, end + reach * along]), TARGET, 2.0, 8.0),
        Line(np.array([tail, tip]), TARGET, 2.0),
        Line(np.array([barbs[0], tip, barbs[1]]), TARGET, 2.0),
        Label(end + reach * along, fold.name, -fold.towards, TARGET),
    ]
    shapes += [Dot(place, LEFT, 3.0) for place in fold.left]
    return shapes + [Dot(place, RIGHT, 3.0) for place in fold.right]


def _arrow(fold: FoldMark, arm: float, others: shapely.Geometry, clear: float) -> np.ndarray:
    """Tail and tip of a fold's arrow: over the middle of its line, or beside it where other lines are there."""
    start, end = fold.line
    arms = np.outer([-arm, arm], fold.towards)
    arrows = [start + part * (end - start) + arms for part in ALONG]
    free = (arrow for arrow in arrows if others.is_empty or others.distance(shapely.LineString(arrow)) >= clear)
    return next(free, arrows[0])


def _ruler(low: np.ndarray, high: np.ndarray) -> list[Shape]:
    """Ten centimetres in a corner, and the axes in another."""
    gap = 0.06 * float(high[0] - low[0])
    left = np.array([low[0] + gap, high[1] - gap])
    corner = np.array([low[0] + gap, low[1] + 1.6 * gap])
    ahead, aside = corner + gap * np.eye(2)
    return [
        Line(np.array([left, left - [0.0, 0.1]]), FAINT, 2.0),
        Label(left - [0.0, 0.05], "10 cm", np.array([1.0, 0.0]), FAINT),
        Line(np.array([ahead, corner, aside]), FAINT, 1.5),
        Label(ahead, "x", np.array([1.0, 0.0]), FAINT),
        Label(aside, "y", np.array([0.0, 1.0]), FAINT),
    ]


def facts(garment: Garment) -> list[tuple[str, str]]:
    """What there is to say of a garment, names and values."""
    rest = garment.vertices if garment.rest is None else garment.rest
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
    """The drawing and all facts as one HTML page that opens offline."""
    style = (files("tatamu.report") / "style.css").read_text(encoding="utf-8")
    notes = "".join(f"<li>{text(note)}</li>" for note in garment.notes)
    material = [(name, f"{value:g}") for name, value in garment.material.model_dump().items() if name != "blender"]
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{text(garment.name)}</title><style>:root{{{css()}}}{style}"
        "figure svg{max-height:86vh;border-radius:10px}</style></head><body>"
        f'<header><p class="brand">tatamu <span>a garment</span></p><h1>{text(garment.name)}</h1></header><main>'
        + (f'<ul class="warnings">{notes}</ul>' if notes else "")
        + f'<section class="card"><figure>{diagram(garment, folds).svg()}<figcaption>{_legend(folds)}</figcaption>'
        f"</figure></section><h2>Facts</h2><section class='card'>{rows(facts(garment))}</section>"
        f"<h2>Edges</h2><section class='card'>{_edge_table(garment)}</section>"
        f"<h2>Material</h2><section class='card'>{rows(material)}</section></main>"
        f"<footer><p class='about'>tatamu {__version__}</p></footer></body></html>\n"
    )


def _legend(folds: Sequence[FoldMark]) -> str:
    keys = [(SEAM, "seam"), (OPENING, "open edge")]
    if folds:
        keys += [(TARGET, "fold line"), (LEFT, "grasps of the left hand"), (RIGHT, "grasps of the right hand")]
    return " · ".join(f'<span style="color:{colour}">■</span> {name}' for colour, name in keys)


def _edge_table(garment: Garment) -> str:
    plan, lines = garment.vertices[:, :2], []
    for name, path in garment.edges.items():
        length = float(np.linalg.norm(np.diff(plan[path], axis=0), axis=1).sum())
        kind = "open" if name in garment.openings else "sewn"
        lines.append(f"<tr><td>{text(name)}</td><td>{kind}</td><td>{1e3 * length:.0f}</td><td>{len(path)}</td></tr>")
    return table(("edge", "", "length [mm]", "vertices"), lines)
