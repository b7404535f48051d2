"""Garments as cloth simulators ship them: standing, as worn on a body."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import shapely
from scipy import sparse

from tatamu.garments import Garment, make_garment
from tatamu.simulation.mesh.topology import Topology

ROUND = 0.085
"""Half of how deep the body is [m]."""


@cache
def flat_shirt() -> Garment:
    """The T-shirt that is worn, flat."""
    return make_garment("tshirt", spacing=0.0138)


@cache
def inflated_shirt() -> np.ndarray:
    """Positions of the T-shirt that is worn [m]."""
    return inflated(flat_shirt())


def inflated(garment: Garment) -> np.ndarray:
    """Positions of a two-layer garment filled as if by a body [m]; front +z, top +x; hardly any edge changes."""
    plan = garment.vertices[:, :2]
    seams = shapely.MultiLineString(list(plan[garment.seams]))
    distance = shapely.distance(seams, shapely.points(plan))
    nearest = shapely.get_coordinates(shapely.shortest_line(seams, shapely.points(plan)))[::2]
    sewn = np.unique(garment.seams)
    between = np.linalg.norm(plan[:, None] - plan, axis=2)
    room = np.where(between <= distance[None], distance[None], 0.0).max(axis=1)  # largest disc that holds the point
    edges = Topology(garment.faces).edges
    both = np.concatenate([edges, edges[:, ::-1]])
    joined = sparse.csr_array((np.ones(len(both)), both.T), shape=(len(plan),) * 2)
    for _ in range(8):
        room = 0.5 * room + 0.5 * (joined @ room) / joined.sum(axis=1)
    inward = (plan - nearest) / np.maximum(distance, 1e-9)[:, None]
    inward[sewn] = 0.0
    inward[sewn] = (joined @ inward)[sewn]
    inward /= np.maximum(np.linalg.norm(inward, axis=1), 1e-9)[:, None]
    radius = np.minimum(ROUND, 0.6 * room)
    arc = np.minimum(distance, 0.5 * np.pi * radius)
    beyond = distance - arc
    offset = (0.5 * np.pi - 1.0) * radius + radius * (1.0 - np.cos(arc / radius)) + beyond
    side = np.where(garment.vertices[:, 2] > garment.material.thickness, 1.0, -1.0)
    side[sewn] = 0.0
    x, y = (nearest + inward * offset[:, None]).T
    z = side * radius * np.sin(arc / radius)
    filled = np.column_stack([x, y, z - 0.4 * y**2])  # shoulders are drawn forwards
    flat = np.column_stack([plan, np.zeros(len(plan))])
    return relaxed(filled, edges, np.linalg.norm(flat[edges[:, 0]] - flat[edges[:, 1]], axis=1))


def relaxed(points: np.ndarray, edges: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Positions after each edge was drawn to its length [m] again and again."""
    count = np.bincount(edges.ravel(), minlength=len(points))[:, None]
    points = points.copy()
    for _ in range(600):
        way = points[edges[:, 1]] - points[edges[:, 0]]
        long = np.linalg.norm(way, axis=1)
        pull = (0.6 * (1.0 - lengths / np.maximum(long, 1e-9)))[:, None] * way
        move = np.zeros_like(points)
        np.add.at(move, edges[:, 0], pull)
        np.add.at(move, edges[:, 1], -pull)
        points += move / count
    return points


def with_sleeves_down(points: np.ndarray, garment: Garment, degrees: float) -> np.ndarray:
    """A worn T-shirt, y up, with its sleeves turned down in the plane of its front."""
    out = points.copy()
    for side in (1.0, -1.0):
        away = side * points[:, 0] - 0.13
        angle = side * np.radians(degrees) * np.clip(away / 0.05, 0.0, 1.0)
        shoulder = np.array([0.14 * side, 0.20])
        x, y = (points[:, :2] - shoulder).T
        turned = np.column_stack([np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x])
        out[away > 0.0, :2] = (turned + shoulder)[away > 0.0]
    edges = Topology(garment.faces).edges
    plan = garment.vertices[:, :2]
    return relaxed(out, edges, np.linalg.norm(plan[edges[:, 0]] - plan[edges[:, 1]], axis=1))


def worn_shirt_obj(folder: Path, unit: float = 0.1, up: str = "y", uv: bool = False, name: str = "worn.obj") -> Path:
    """A T-shirt upright, in units of 0.1 m; with a UV map, front and back are its two panels."""
    shirt = flat_shirt()
    x, y, z = inflated_shirt().T / unit
    placed = np.column_stack([-y, x, z] if up == "y" else [-y, -z, x])
    lines = ["# T-shirt, g\xe9n\xe9r\xe9"]  # in Latin-1
    lines += ["v {:.6f} {:.6f} {:.6f}".format(*place) for place in placed]
    if uv:
        a, b, c = (shirt.vertices[shirt.faces[:, k], :2] for k in range(3))
        front = (b - a)[:, 0] * (c - a)[:, 1] > (b - a)[:, 1] * (c - a)[:, 0]
        for shift in (0.0, 0.6):
            lines += [f"vt {(px + 0.3) / 1.3:.6f} {(py + 0.3 + shift) / 1.3:.6f}" for px, py in shirt.vertices[:, :2]]
        count = len(shirt.vertices)
        for face, ahead in zip(shirt.faces + 1, front, strict=True):
            lines.append("f " + " ".join(f"{v}/{v + (0 if ahead else count)}" for v in face))
    else:
        lines += ["f {} {} {}".format(*face) for face in shirt.faces + 1]
    (folder / name).write_bytes("\n".join(lines).encode("latin-1") + b"\n")
    return folder / name
