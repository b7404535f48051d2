"""Drawings of the tests, from simulated shapes: for the docs and beside the fits."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from tatamu.topology import Topology

if TYPE_CHECKING:
    from tatamu.calibration.elongation import Elongation
    from tatamu.calibration.friction import Slope
    from tatamu.calibration.loop import Loop
    from tatamu.calibration.push import Push
    from tatamu.calibration.sag import Sag

INK, CLOTH, GRIP, READ, FAINT = "#1f2933", "#3f66b0", "#52606d", "#d64a57", "#9aa5b1"
MARGIN = 34.0
"""Around the drawing [px]."""


@dataclass
class Drawing:
    """An SVG drawing in metres, z up."""

    low: np.ndarray
    """Corner of what is drawn [m], shape (2,)."""
    high: np.ndarray
    scale: float
    """[px/m]"""
    parts: list[str] = field(default_factory=list)

    @classmethod
    def around(cls, points: np.ndarray, width: float = 300.0, height: float = 260.0) -> Drawing:
        """A drawing that holds points, shape (n, 2), within width x height [px]."""
        low, high = points.min(axis=0), points.max(axis=0)
        return cls(low, high, float(min(np.array([width, height]) / np.maximum(high - low, 1e-9))))

    def at(self, point: np.ndarray | tuple[float, float]) -> tuple[float, float]:
        """Pixels of a point [m]."""
        x, z = np.asarray(point, dtype=float)
        return MARGIN + self.scale * (x - self.low[0]), MARGIN + self.scale * (self.high[1] - z)

    def line(self, points: np.ndarray, colour: str = INK, width: float = 1.5, fill: str = "none", **more: str) -> None:
        """A polyline, shape (n, 2)."""
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.at, points))
        extra = "".join(f' {key.replace("_", "-")}="{value}"' for key, value in more.items())
        self.parts.append(
            f'<polyline points="{path}" fill="{fill}" stroke="{colour}" stroke-width="{width}" '
            f'stroke-linejoin="round"{extra}/>'
        )

    def mesh(self, points: np.ndarray, edges: np.ndarray) -> None:
        """Edges between points, shape (n, 2), as thin lines."""
        ends = np.array([[self.at(points[i]), self.at(points[j])] for i, j in edges]).round(1)
        path = "".join(f"M{a[0]:g},{a[1]:g}L{b[0]:g},{b[1]:g}" for a, b in ends)
        self.parts.append(f'<path d="{path}" fill="none" stroke="{CLOTH}" stroke-width="0.5" opacity="0.6"/>')

    def dimension(self, start: np.ndarray, end: np.ndarray, name: str, colour: str = READ) -> None:
        """A line with arrows at both ends and its name beside its middle."""
        (x0, y0), (x1, y1) = self.at(start), self.at(end)
        self.parts.append(
            f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" stroke="{colour}" stroke-width="1.5" '
            f'marker-start="url(#arrow)" marker-end="url(#arrow)"/>'
        )
        upright = abs(x1 - x0) < abs(y1 - y0)
        x, y = (x0 + x1) / 2 + (6 if upright else 0), (y0 + y1) / 2 + (4 if upright else -6)
        self.parts.append(self._text(x, y, name, colour, "start" if upright else "middle"))

    def label(self, point: np.ndarray | tuple[float, float], name: str, colour: str = INK) -> None:
        """Words at a place."""
        self.parts.append(self._text(*self.at(point), name, colour, "middle"))

    def _text(self, x: float, y: float, name: str, colour: str, anchor: str) -> str:
        return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}">{escape(name)}</text>'

    def svg(self) -> str:
        """The whole drawing."""
        width, height = self.scale * (self.high - self.low) + 2 * MARGIN
        arrow = (
            f'<marker id="arrow" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
            f'orient="auto-start-reverse"><path d="M0,1 L7,4 L0,7" fill="none" stroke="{READ}" stroke-width="1.4"/>'
            f"</marker>"
        )
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" '
            f'height="{height:.0f}" font-family="system-ui, sans-serif" font-size="13"><defs>{arrow}</defs>'
            f'<rect width="100%" height="100%" fill="white"/>{"".join(self.parts)}</svg>\n'
        )


def _side(along: np.ndarray, end: np.ndarray) -> np.ndarray:
    """A strip from the side: the mean of each of its rows [m], shape (rows, 2).

    Args:
        along: Where each vertex is along the unfolded strip [m], shape (n,).
        end: Positions [m], shape (n, 3).
    """
    along = along.round(6)
    return np.array([end[along == row][:, [0, 2]].mean(axis=0) for row in np.unique(along)])


def hanging(test: Elongation, shape: np.ndarray) -> str:
    """The garment as it hangs, positions [m] of shape (n, 3), and as it lies beside."""
    hung = shape[:, 1:]
    flat = test.plan * [1.0, -1.0]
    aside = np.array([1.45 * np.ptp(flat[:, 0]), 0.0])
    room = np.array([[0.25 * aside[0], 0.06 * np.ptp(flat[:, 1])]])
    drawing = Drawing.around(np.concatenate([hung, flat + aside, (flat + aside).max(0)[None] + room]), 340.0)
    edges = Topology(test.garment.faces).edges
    for view in (hung, flat + aside):
        drawing.mesh(view, edges)
    for held in test.held:
        grip = hung[held]
        ends = grip[[grip[:, 0].argmin(), grip[:, 0].argmax()]]
        drawing.line(ends, GRIP, 7.0, stroke_linecap="round")
    for view, end, name in ((hung, hung[test.end, 1].mean(), "L1"), (flat + aside, -test.length, "L2")):
        right = view[:, 0].max() + 0.04 * aside[0]
        drawing.dimension(np.array([right, 0.0]), np.array([right, end]), name)
    top = hung[:, 1].max() + 0.03 * np.ptp(flat[:, 1])
    drawing.label((hung[:, 0].mean(), top), "hanging", GRIP)
    drawing.label(((flat + aside)[:, 0].mean(), top), "lying", GRIP)
    return drawing.svg()


def sliding(slope: Slope) -> str:
    """The board, the cloth on it, and what is read."""
    board = 0.6
    foot, top = np.zeros(2), board * np.array([np.cos(slope.angle), np.sin(slope.angle)])
    normal = np.array([-np.sin(slope.angle), np.cos(slope.angle)])
    drawing = Drawing.around(np.array([foot, (top[0] + 0.08, top[1] + 0.05), (top[0] + 0.1, 0.0)]), 320.0, 240.0)
    drawing.line(np.array([foot - [0.02, 0.0], [top[0] + 0.1, 0.0]]), FAINT, 1.5)
    drawing.line(np.array([foot, top]), GRIP, 5.0, stroke_linecap="round")
    middle, half = 0.55 * top, 0.5 * 1.2 * slope.sheet[1] * top / board
    drawing.line(np.array([middle - half, middle + half]) + 0.012 * normal, CLOTH, 5.0, stroke_linecap="round")
    drawing.dimension(np.array([top[0] + 0.03, 0.0]), np.array([top[0] + 0.03, top[1]]), "H_s")
    drawing.dimension(foot + 0.05 * normal, top + 0.05 * normal, "L_t")
    turn = np.linspace(0.0, slope.angle, 24)
    drawing.line(0.12 * np.column_stack([np.cos(turn), np.sin(turn)]), INK, 1.0)
    drawing.label((0.16 * np.cos(slope.angle / 2), 0.16 * np.sin(slope.angle / 2) - 0.008), "θ")
    return drawing.svg()


def sagging(test: Sag, end: np.ndarray) -> str:
    """The strip in front of its grip, positions [m] of shape (n, 3), from the side."""
    rows, side = np.unique(test.mesh[0][:, 0].round(6)), _side(test.mesh[0][:, 0], end)
    front = test.free_length
    back = rows[-1] + 0.25 * front
    thick = 0.07 * front
    corners = np.array([[front, thick], [back, -thick], side.min(axis=0), [side[0, 0] - 0.3 * front, 0.2 * front]])
    drawing = Drawing.around(np.concatenate([side, corners]), 320.0, 220.0)
    for sign in (1.0, -1.0):
        box = np.array([[front, 0.0], [back, 0.0], [back, sign * thick], [front, sign * thick], [front, 0.0]])
        drawing.line(box, GRIP, 1.0, fill="#cbd2d9")
    drawing.line(side, CLOTH, 3.5, stroke_linecap="round")
    drawing.line(np.array([[front, 0.0], [side[0, 0] - 0.2 * front, 0.0]]), FAINT, 1.0, stroke_dasharray="4 4")
    drawing.dimension(
        np.array([side[0, 0] - 0.12 * front, 0.0]), np.array([side[0, 0] - 0.12 * front, side[0, 1]]), "sag"
    )
    away = 0.1 * front
    lifted = side[rows <= front] + [0.0, away]
    drawing.line(np.vstack([lifted, [front, away]]), READ, 1.2, marker_start="url(#arrow)", marker_end="url(#arrow)")
    drawing.label((0.72 * front, 0.16 * front), "free_length", READ)
    drawing.label(((front + back) / 2, -0.22 * front), "grip", GRIP)
    return drawing.svg()


def looped(test: Loop, end: np.ndarray) -> str:
    """The strip folded over itself, positions [m] of shape (n, 3), from the side."""
    side = _side(test.mesh[0][:, 0], end)
    height, reach = test.height_of(end), side[:, 0].max()
    side = side[side[:, 0] > reach - 3.2 * height]
    left = side[:, 0].min()
    drawing = Drawing.around(np.concatenate([side, [[left, 0.0], [reach + 0.9 * height, 1.15 * height]]]), 320.0, 220.0)
    table = np.array([[left, 0.0], [reach + 0.9 * height, 0.0]])
    drawing.line(table, GRIP, 3.0)
    half = side[:, 0].argmax()
    for part in (side[: half + 1], side[half:]):
        drawing.line(part, CLOTH, max(2.0, test.thickness * drawing.scale * 0.8), stroke_linecap="round")
    read = reach + 0.35 * height
    drawing.line(np.array([[side[side[:, 1].argmax(), 0], height], [read, height]]), FAINT, 1.0, stroke_dasharray="4 4")
    drawing.dimension(np.array([read, 0.0]), np.array([read, height]), "height")
    return drawing.svg()


def pushed(test: Push, end: np.ndarray) -> str:
    """The strip after the push, positions [m] of shape (n, 3), from the side, and where its ends were before."""
    side = _side(test.mesh[0][:, 0], end)
    low, high = 0.12 * test.length, 0.05 * test.length
    corners = np.array([[-0.08 * test.length, -low], [test.length + max(0.08 * test.length, test.pushed), 2.2 * high]])
    drawing = Drawing.around(np.concatenate([side, corners]), 420.0, 220.0)
    drawing.line(np.array([[corners[0, 0], 0.0], [corners[1, 0], 0.0]]), GRIP, 3.0)
    drawing.line(side + np.array([0.0, 2.0 / drawing.scale]), CLOTH, 3.5, stroke_linecap="round")
    ruler = side[0]
    box = np.array([[0.0, 0.0], [-0.03, 0.0], [-0.03, 2.0], [0.0, 2.0], [0.0, 0.0]]) * [test.length, high] + ruler
    drawing.line(box, GRIP, 1.0, fill="#cbd2d9")
    for start, now, name in ((0.0, side[0, 0], "pushed"), (test.length, side[-1, 0], "moved")):
        drawing.line(np.array([[start, -0.7 * low], [start, 1.6 * high]]), FAINT, 1.0, stroke_dasharray="4 4")
        if now - start > 1e-3:
            drawing.dimension(np.array([start, -0.4 * low]), np.array([now, -0.4 * low]), "")
        drawing.label((0.5 * (start + now), -0.9 * low), name, READ)
    drawing.dimension(np.array([0.0, 1.8 * high]), np.array([test.length, 1.8 * high]), "length")
    return drawing.svg()
