"""Drawings of the tests, from simulated shapes: for the docs and beside the fits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tatamu.presentation.drawing import Drawing
from tatamu.presentation.shapes import Box, Segments
from tatamu.topology import Topology

if TYPE_CHECKING:
    from tatamu.calibration.bias import Bias
    from tatamu.calibration.crease import PressedCrease
    from tatamu.calibration.elongation import Elongation
    from tatamu.calibration.friction import Slope
    from tatamu.calibration.loop import Loop
    from tatamu.calibration.plate import Plate
    from tatamu.calibration.push import Push
    from tatamu.calibration.sag import Sag
    from tatamu.calibration.swing import Swinging

CLOTH = "plot"
DASH = 4.0
"""Of lines that are there to read a length by [pixels]."""


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
    drawing = Drawing.around(np.concatenate([hung, flat + aside, (flat + aside).max(0)[None] + room]), 340.0, 260.0)
    edges = Topology(test.garment.faces).edges
    for view in (hung, flat + aside):
        drawing.add(Segments(view[edges], CLOTH, 0.5, opacity=0.6))
    for held in test.held:
        grip = hung[held]
        ends = grip[[grip[:, 0].argmin(), grip[:, 0].argmax()]]
        drawing.line(ends, "muted", 7.0)
    for view, end, name in ((hung, hung[test.end, 1].mean(), "L1"), (flat + aside, -test.length, "L2")):
        right = view[:, 0].max() + 0.04 * aside[0]
        drawing.dimension(np.array([right, 0.0]), np.array([right, end]), name)
    top = hung[:, 1].max() + 0.01 * np.ptp(flat[:, 1])
    drawing.label((hung[:, 0].mean(), top), "hanging", "muted", (0.0, 1.0))
    drawing.label(((flat + aside)[:, 0].mean(), top), "lying", "muted", (0.0, 1.0))
    return drawing.svg()


def on_bias(test: Bias, shape: np.ndarray) -> str:
    """The strip as it hangs, positions [m] of shape (n, 3), with its yarns, and as it lies beside."""
    hung = shape[:, 1:]
    flat = test.mesh[0][:, ::-1] * [1.0, -1.0]
    aside = np.array([0.45 * test.length, 0.0])
    room = np.array([0.2 * test.length, 0.03 * test.length])
    drawing = Drawing.around(np.concatenate([hung - room, hung + room, flat + aside + room]), 240.0, 300.0)
    edges = Topology(test.mesh[1]).edges
    for view, end, name in ((hung, hung[:, 1].min(), "L1"), (flat + aside, -test.length, "L2")):
        drawing.add(Segments(view[edges], CLOTH, 0.5, opacity=0.6))
        right = view[:, 0].max() + 0.04 * test.length
        drawing.dimension(np.array([right, 0.0]), np.array([right, end]), name)
    half = 0.5 * test.width
    drawing.line(np.array([[-half, 0.0], [half, 0.0]]), "muted", 7.0)
    middle = aside - [0.0, 0.5 * test.length]
    for turn in (1.0, -1.0):
        yarn = 0.8 * half * np.array([1.0, turn])
        drawing.arrow(np.array([middle - yarn, middle + yarn]), "ink", 1.2, both=True)
    drawing.label(middle - np.array([0.0, 0.9 * half]), "yarns", "ink", (0.0, -1.0))
    return drawing.svg()


def sliding(slope: Slope) -> str:
    """The board, the cloth on it, and what is read."""
    board = 0.6
    foot = np.zeros(2)
    top = board * np.array([np.cos(slope.angle), np.sin(slope.angle)])
    normal = np.array([-np.sin(slope.angle), np.cos(slope.angle)])
    drawing = Drawing.around(np.array([foot, (top[0] + 0.08, top[1] + 0.05), (top[0] + 0.1, 0.0)]), 320.0, 240.0)
    drawing.line(np.array([foot - [0.02, 0.0], [top[0] + 0.1, 0.0]]), "muted", 1.5)
    drawing.line(np.array([foot, top]), "muted", 5.0)
    middle = 0.55 * top
    half = 0.5 * 1.2 * slope.sheet[1] * top / board
    drawing.line(np.array([middle - half, middle + half]) + 0.012 * normal, CLOTH, 5.0)
    drawing.dimension(np.array([top[0] + 0.03, 0.0]), np.array([top[0] + 0.03, top[1]]), "H_s")
    drawing.dimension(foot + 0.05 * normal, top + 0.05 * normal, "L_t")
    turn = np.linspace(0.0, slope.angle, 24)
    drawing.line(0.12 * np.column_stack([np.cos(turn), np.sin(turn)]), "ink", 1.0)
    drawing.label((0.16 * np.cos(slope.angle / 2), 0.16 * np.sin(slope.angle / 2) - 0.008), "θ")
    return drawing.svg()


def sagging(test: Sag, end: np.ndarray) -> str:
    """The strip in front of its grip, positions [m] of shape (n, 3), from the side."""
    rows = np.unique(test.mesh[0][:, 0].round(6))
    side = _side(test.mesh[0][:, 0], end)
    front = test.free_length
    back = rows[-1] + 0.25 * front
    thick = 0.07 * front
    corners = np.array([[front, thick], [back, -thick], side.min(axis=0), [side[0, 0] - 0.3 * front, 0.2 * front]])
    drawing = Drawing.around(np.concatenate([side, corners]), 320.0, 220.0)
    for sign in (1.0, -1.0):
        drawing.add(Box(np.array([front, 0.0]), np.array([back, sign * thick]), "grip", "muted"))
    drawing.line(side, CLOTH, 3.5)
    drawing.line(np.array([[front, 0.0], [side[0, 0] - 0.2 * front, 0.0]]), "muted", 1.0, dash=DASH)
    drawing.dimension(
        np.array([side[0, 0] - 0.12 * front, 0.0]), np.array([side[0, 0] - 0.12 * front, side[0, 1]]), "sag"
    )
    away = 0.1 * front
    lifted = side[rows <= front] + [0.0, away]
    drawing.arrow(np.vstack([lifted, [front, away]]), "reading", 1.2, both=True)
    drawing.label((0.72 * front, 0.16 * front), "free_length", "reading")
    drawing.label(((front + back) / 2, -0.22 * front), "grip", "muted")
    return drawing.svg()


def looped(test: Loop, end: np.ndarray) -> str:
    """The strip folded over itself, positions [m] of shape (n, 3), from the side."""
    side = _side(test.mesh[0][:, 0], end)
    height = test.height_of(end)
    reach = side[:, 0].max()
    side = side[side[:, 0] > reach - 3.2 * height]
    left = side[:, 0].min()
    drawing = Drawing.around(np.concatenate([side, [[left, 0.0], [reach + 0.9 * height, 1.15 * height]]]), 320.0, 220.0)
    table = np.array([[left, 0.0], [reach + 0.9 * height, 0.0]])
    drawing.line(table, "muted", 3.0)
    half = side[:, 0].argmax()
    for part in (side[: half + 1], side[half:]):
        drawing.line(part, CLOTH, max(2.0, test.thickness * drawing.scale * 0.8))
    read = reach + 0.35 * height
    drawing.line(np.array([[side[side[:, 1].argmax(), 0], height], [read, height]]), "muted", 1.0, dash=DASH)
    drawing.dimension(np.array([read, 0.0]), np.array([read, height]), "height")
    return drawing.svg()


def creased(test: PressedCrease, end: np.ndarray) -> str:
    """The hinge and its two boards, positions [m] of shape (n, 3), from above."""
    side = test.side(end)
    board = 2.0 * test.gap
    first, last = (side[near] - side[next_] for near, next_ in ((0, 1), (-1, -2)))
    outer = [at + board * way / np.linalg.norm(way) for at, way in ((side[0], first), (side[-1], last))]
    flat = side[-1] - board * first / np.linalg.norm(first)
    middle = side[-1]
    drawing = Drawing.around(np.concatenate([side, outer, [flat - np.array([0.0, 0.2 * board])]]), 320.0, 200.0)
    drawing.line(np.vstack([middle - [test.gap, 0.0], flat]), "muted", 1.0, dash=DASH)
    for at, far in zip((side[0], side[-1]), outer, strict=True):
        drawing.line(np.array([at, far]), "muted", 7.0)
    drawing.line(side, CLOTH, 3.5)
    turn = np.linspace(0.0, test.angle_of(end), 24)
    drawing.line(middle + 0.8 * board * np.column_stack([np.cos(turn), np.sin(turn)]), "reading", 1.2)
    half = 0.5 * turn[-1]
    drawing.label(middle + 0.95 * board * np.array([np.cos(half), np.sin(half)]), "angle", "reading")
    drawing.label((0.5 * (side[0] + side[-1])) + [0.0, -0.25 * board], "gap", "ink")
    return drawing.svg()


def pushed(test: Push, end: np.ndarray) -> str:
    """The strip after the push, positions [m] of shape (n, 3), from the side, and where its ends were before."""
    side = _side(test.mesh[0][:, 0], end)
    low = 0.12 * test.length
    high = 0.05 * test.length
    corners = np.array([[-0.08 * test.length, -low], [test.length + max(0.08 * test.length, test.pushed), 2.2 * high]])
    drawing = Drawing.around(np.concatenate([side, corners]), 420.0, 220.0)
    drawing.line(np.array([[corners[0, 0], 0.0], [corners[1, 0], 0.0]]), "muted", 3.0)
    drawing.line(side + np.array([0.0, 2.0 / drawing.scale]), CLOTH, 3.5)
    ruler = side[0]
    drawing.add(Box(ruler, ruler + np.array([-0.03 * test.length, 2.0 * high]), "grip", "muted"))
    for start, now, name in ((0.0, side[0, 0], "pushed"), (test.length, side[-1, 0], "moved")):
        drawing.line(np.array([[start, -0.7 * low], [start, 1.6 * high]]), "muted", 1.0, dash=DASH)
        if now - start > 1e-3:
            drawing.dimension(np.array([start, -0.4 * low]), np.array([now, -0.4 * low]), "")
        drawing.label((0.5 * (start + now), -0.9 * low), name, "reading")
    drawing.dimension(np.array([0.0, 1.8 * high]), np.array([test.length, 1.8 * high]), "length")
    return drawing.svg()


def over_plate(test: Plate, shape: np.ndarray) -> str:
    """The disc on its plate, positions [m] of shape (n, 3), from above."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    drawing = Drawing.around(np.array([[-1.05, -1.25], [1.05, 1.05]]) * test.disc, 300.0, 260.0)
    drawing.line(test.disc * circle, "muted", 1.0, dash=DASH)
    drawing.line(test.outlines(shape)[0].curve, CLOTH, 2.5, fill="cloth")
    drawing.line(test.plate * circle, "muted", 1.5, fill="grip")
    drawing.dimension(np.array([-test.plate, 0.0]), np.array([test.plate, 0.0]), "plate")
    low = -1.15 * test.disc
    drawing.dimension(np.array([-test.disc, low]), np.array([test.disc, low]), "disc")
    return drawing.svg()


def swung(test: Swinging, start: np.ndarray) -> str:
    """The garment from the side as it is let go, positions [m] of shape (n, 3), and as it hangs."""
    length = test.hung.length
    end = start[test.hung.end].mean(axis=0)[[0, 2]]
    top = np.zeros(2)
    corners = np.array([[-0.35 * length, 0.05 * length], [1.2 * end[0] + 0.1 * length, -1.12 * length]])
    drawing = Drawing.around(corners, 260.0, 260.0)
    drawing.line(np.array([top, end]), CLOTH, 4.0)
    drawing.line(np.array([top, [0.0, -length]]), "muted", 1.0, dash=DASH)
    drawing.line(np.array([top, end * [-0.9, 1.0]]), "mesh", 2.0)
    drawing.line(np.array([[-0.06 * length, 0.0], [0.06 * length, 0.0]]), "muted", 7.0)
    low = -1.06 * length
    drawing.dimension(np.array([0.0, low]), np.array([end[0], low]), "aside")
    return drawing.svg()
