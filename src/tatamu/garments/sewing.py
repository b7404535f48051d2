"""Makes garments from an outline: a single layer, or a front and a back panel that are sewn together."""

from __future__ import annotations

from collections.abc import Collection
from contextlib import suppress

import numpy as np

from tatamu.base.errors import InputError
from tatamu.garments.garment import Garment, check_size, check_spacing, default_spacing, largest_spacing
from tatamu.garments.outline import Outline
from tatamu.garments.panel import Panel, panel, without_chords
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import Topology, among, connected


def one_layer(name: str, outline: Outline, material: Material, spacing: float | None = None) -> Garment:
    """Make a garment of a single panel. Every side of its outline is open."""
    mesh, spacing, notes = _meshed(spacing, outline, material, 1)
    vertices = np.column_stack([mesh.points, np.full(len(mesh.points), 0.5 * material.thickness)])
    openings = tuple(mesh.paths)
    return Garment(
        name, outline.size, spacing, vertices, mesh.faces, material, edges=mesh.paths, openings=openings, notes=notes
    )


def front_and_back(
    name: str, outline: Outline, openings: Collection[str], material: Material, spacing: float | None = None
) -> Garment:
    """Make a garment of two panels, a front over a back, which are sewn together at all sides except `openings`.

    The panels share the vertices of seams. If the outline has a line, such as the lower neckline of a front, the front
    ends there, and only the back has cloth up to the neighbouring opening.

    Raises:
        InputError: If the outline cannot be meshed, or an opening is missing or no side of the outline.
    """
    unknown = sorted(set(openings) - set(outline.sides))
    if unknown or not openings:
        given = repr(unknown[0]) if unknown else "none"
        raise InputError(f"openings: must be one or more of {', '.join(outline.sides)}, given {given}")
    mesh, spacing, notes = _meshed(spacing, outline, material, 2)
    closed = [mesh.paths[side] for side in outline.sides if side not in openings]
    if closed:
        mesh = without_chords(mesh, np.concatenate(closed))
    front = mesh.faces[_within(mesh, [mesh.paths[line] for line in outline.lines])]
    shared = np.zeros(len(mesh.points), dtype=bool)
    shared[np.concatenate([*closed, []]).astype(np.int64)] = True
    own = np.setdiff1d(front, np.flatnonzero(shared))
    upper = np.arange(len(mesh.points))  # number of the uppermost vertex at each mesh vertex
    upper[own] = len(mesh.points) + np.arange(len(own))
    flat = np.concatenate([mesh.points, mesh.points[own]])
    t = material.thickness
    height = np.concatenate([np.where(shared, t, 0.5 * t), np.full(len(own), 1.5 * t)])
    return Garment(
        name=name,
        size=outline.size,
        spacing=spacing,
        vertices=np.column_stack([flat, height]),
        faces=np.concatenate([mesh.faces[:, ::-1], upper[front]]),
        material=material,
        seams=_steps(closed),
        rest=np.column_stack([flat, np.zeros(len(flat))]),
        edges={side: upper[path] for side, path in mesh.paths.items()},
        openings=(*(side for side in outline.sides if side in openings), *outline.lines),
        notes=notes,
    )


def _meshed(
    given: float | None, outline: Outline, material: Material, layers: int
) -> tuple[Panel, float, tuple[str, ...]]:
    """Return the mesh of a panel, its spacing, which is given or chosen [m], and notes."""
    area = layers * outline.polygon.area
    check_size(outline.size)
    if given is not None:
        check_spacing(given, outline.size, area)
        outline, notes = outline.without_marks(given)
        return panel(outline, given), given, notes
    spacing = min(default_spacing(material, area), largest_spacing(outline.size))
    outline, notes = outline.without_marks(spacing)
    for _ in range(4):  # finer and finer
        with suppress(InputError):
            check_spacing(spacing, outline.size, area)
            return panel(outline, spacing), spacing, notes
        spacing *= 0.75
    raise InputError(
        "outline: some parts are too narrow or too close together for a mesh; give a smaller spacing, or a simpler "
        "outline"
    )


def _steps(paths: list[np.ndarray]) -> np.ndarray:
    """Return the edges of a mesh along paths of vertices, shape (s, 2)."""
    return np.concatenate([np.empty((0, 2), np.int64), *(np.column_stack([path[:-1], path[1:]]) for path in paths)])


def _within(mesh: Panel, lines: list[np.ndarray]) -> np.ndarray:
    """Return whether each triangle belongs to the largest part that lines cut off, shape (m,)."""
    topology = Topology(mesh.faces)
    across = topology.neighbours[~among(topology.inner_edges, _steps(lines))]
    part = connected(across, len(mesh.faces))
    return part == np.argmax(np.bincount(part))
