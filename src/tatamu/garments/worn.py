"""Makes a garment from a mesh file. A flat mesh is used as it is; one worn on a body is laid flat first.

If the UV map of the file is the sewing pattern, the warp is along +v of every panel, because patterns are drawn along
the grain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from tatamu.base.errors import InputError
from tatamu.garments.description import GarmentFile
from tatamu.garments.drawing import distinct, found_by_name, in_toml
from tatamu.garments.flat import flat_garment, laid_flat, meshed_anew
from tatamu.garments.flattening import flattened, inside_out, panel_numbers, side_lengths
from tatamu.garments.garment import Garment, check_size
from tatamu.garments.meshfile import faults, pieces, read_mesh, welded
from tatamu.garments.objfile import TriangleMesh
from tatamu.garments.posture import posture
from tatamu.garments.robust import robust_fit
from tatamu.garments.units import DOUBTFUL, Unit, check_size_of_file, direction, doubts, how_to_scale
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import facing_down


def from_mesh(given: GarmentFile, source: Path, material: Material) -> Garment:
    """Make the garment of a mesh file.

    Raises:
        InputError: If the file cannot be read, the mesh has faults, or it cannot be laid flat.
    """
    if given.spacing is not None and not given.remesh:
        raise InputError(
            "spacing: must be left out, because the edges of the mesh set the spacing; for another spacing, write "
            "remesh = true under [garment]"
        )
    kind = source.suffix[1:].upper()
    stated = "as glTF has it" if kind == "GLB" else f"assumed: {kind} states no unit"
    unit = Unit(1.0, "metres", stated).scaled(given.scale)
    mesh, notes = _cloth(given, read_mesh(source), source, unit)
    extent = np.sort(np.ptp(mesh.vertices, axis=0))
    flat = bool(extent[0] <= 0.03 * extent[1])
    sides = (float(extent[1]), float(extent[2]))
    if given.size is None:
        check_size_of_file(sides, "mesh", unit)
    else:
        check_size(given.size)
    found = faults(mesh.vertices, mesh.faces)
    if found:
        raise InputError(f"mesh: has {'; '.join(found)}")
    if not flat and given.size is None and max(sides) > DOUBTFUL:
        advice = how_to_scale(sides, unit)
        raise InputError(
            f"mesh: each side must be at most {DOUBTFUL:g} m, given {max(sides):.3g} m, {unit.words}{advice}"
        )
    garment = _lying(given, mesh, material) if flat else _laid(given, mesh, material)
    doubt = [] if given.size else doubts(sides, unit)
    notes = [*notes, *doubt, *garment.notes]
    cells = garment.spacing / garment.material.bending_length
    if cells > 0.65:  # docs/theory/bending.md
        edges = f"its edges of {1e3 * garment.spacing:.1f} mm are {cells:.2f} bending lengths, more than 0.65"
        notes.append(f"the mesh has such large triangles that folds look too stiff ({edges}); give a finer mesh")
    return replace(garment, reading=unit.reading(given.size), notes=tuple(notes))


def _cloth(given: GarmentFile, mesh: TriangleMesh, source: Path, unit: Unit) -> tuple[TriangleMesh, list[str]]:
    """Return the piece of cloth of a mesh, in metres, and notes on changes."""
    mesh = replace(mesh, vertices=mesh.vertices * unit.metres)
    notes = []
    # these formats store a vertex once for each triangle, or for each texture coordinate
    if given.weld or source.suffix.lower() in (".stl", ".glb"):
        before = len(mesh.vertices)
        mesh = welded(mesh)
        if not len(mesh.faces):
            raise InputError("mesh: must contain triangles with an area above 0, given none")
        notes = [f"{before} vertices are welded into {len(mesh.vertices)}"] if before > len(mesh.vertices) else []
    number = pieces(mesh.faces)
    if number.max() == 0 and given.piece is None:
        return mesh, notes
    names = distinct([_piece_name(mesh, number == k, k) for k in range(int(number.max()) + 1)])
    wanted = None if given.piece is None else found_by_name(names, given.piece)
    if wanted is not None:
        return mesh.kept(number == wanted), notes
    known = [f"{in_toml(name)} ({_extent(mesh, number == k)})" for k, name in enumerate(names)]
    listed = ", ".join(known[:8]) + (f" and {len(known) - 8} more" if len(known) > 8 else "")
    if given.piece is not None:
        raise InputError(f"piece: must be one of {listed}, given {given.piece!r}")
    places = len(np.unique(mesh.vertices.round(9), axis=0))
    weld = ", or join the pieces with weld = true" if places < len(mesh.vertices) else ""
    raise InputError(
        f"mesh: must be a single piece, given {len(names)} pieces: {listed}; choose one with "
        f"piece = {in_toml(names[0])} under [garment] in a garment file{weld}"
    )


def _piece_name(mesh: TriangleMesh, own: np.ndarray, number: int) -> str:
    """Return the name that most triangles of a piece have in the file, or else a number."""
    parts = [part for part, keep in zip(mesh.parts, own, strict=True) if keep and part] if mesh.parts else []
    return max(sorted(set(parts)), key=parts.count) if parts else f"piece {number + 1}"


def _extent(mesh: TriangleMesh, own: np.ndarray) -> str:
    points = mesh.vertices[np.unique(mesh.faces[own])]
    return f"{len(points)} vertices, {' x '.join(f'{side:.2f}' for side in np.ptp(points, axis=0))} m"


def _lying(given: GarmentFile, mesh: TriangleMesh, material: Material) -> Garment:
    """Return the garment of a flat mesh, whose plane may have any orientation."""
    thin = int(np.argmin(np.ptp(mesh.vertices, axis=0)))
    usual, facing = (("z", "x"), ("z", "-y"), ("y", "z"))[thin]  # away from the hem, and out of the front
    up = given.up or usual
    if up[-1] == "xyz"[thin]:
        raise InputError(
            f"up: must be an axis in the plane of the mesh, given {up}, which is perpendicular to the mesh"
        )
    ahead, front = direction(up), direction(facing)
    points = mesh.vertices @ np.array([ahead, np.cross(front, ahead), front]).T
    garment = flat_garment(given.name, _sized(points[:, :2], given.size), mesh.faces, material)
    garment = meshed_anew(garment, given.spacing) if given.remesh else garment
    if thin == 2:
        return garment
    note = f"the mesh is laid on the table with {up} up, because its vertices have about equal {'xyz'[thin]}"
    return replace(garment, notes=(note, *garment.notes))


def _laid(given: GarmentFile, mesh: TriangleMesh, material: Material) -> Garment:
    """Return the garment of a worn mesh: flattened if its edges change little, otherwise dropped by simulation."""
    stance = posture(mesh.vertices, mesh.faces, given.up)
    points = (mesh.vertices - mesh.vertices.mean(axis=0)) @ stance.turn.T
    faces = mesh.faces[:, ::-1] if inside_out(points, mesh.faces) else mesh.faces
    uv = mesh.uv if mesh.uv is None or faces is mesh.faces else mesh.uv[:, ::-1]
    pattern = _pattern(points, faces, uv)
    plane = flattened(points, faces, pattern.lengths, pattern.panels)
    deep = float(np.ptp(points[:, 2]))
    notes = [f"the garment is laid flat on its back, because the mesh is {1e3 * deep:.0f} mm deep; {stance.words}"]
    changes = (
        f"its edges change by {100 * plane.median:.1f} % in the median, and 5 of 100 edges by more than "
        f"{100 * plane.most:.1f} %"
    )
    reason = f"{changes}, and {plane.wrong} triangles turn over"
    if plane.median <= 0.05 and plane.most <= 0.20 and not plane.wrong:
        try:
            garment = pattern.woven(flat_garment(given.name, _sized(plane.plan, given.size), faces, material))
        except InputError as error:
            reason = str(error).removeprefix("mesh: ")
        else:
            if given.remesh:
                made = meshed_anew(garment, given.spacing)
                garment = made if garment.fibre is None else replace(made, fibre=_carried(garment.fibre, garment, made))
            doubt = "; look at the picture, because a UV map of the pattern would give a better shape"
            notes.append(f"flattened by {pattern.words}: {changes}{doubt if plane.most > 0.10 else ''}")
            return replace(garment, notes=(*notes, *garment.notes))
    if given.remesh:
        raise InputError(f"remesh: the mesh cannot be flattened ({reason}); leave remesh out")
    stretch = 1.0 if given.size is None else float(np.sqrt(np.prod(given.size) / np.prod(np.ptp(points, axis=0)[:2])))
    try:
        fallen = pattern.woven(laid_flat(given.name, stretch * points, faces, material))
    except InputError as error:
        raise InputError(f"{error}; the mesh was not flattened, because {reason}") from None
    return replace(fallen, notes=(*notes, f"not flattened, because {reason}", *fallen.notes))


def _sized(plan: np.ndarray, size: tuple[float, float] | None) -> np.ndarray:
    """Return flat vertices, stretched to a width and length [m] if they are given."""
    return plan if size is None else plan * (np.array(size[::-1]) / np.ptp(plan, axis=0))


@dataclass(frozen=True)
class _Pattern:
    """The flat shape of each triangle of a worn garment."""

    lengths: np.ndarray
    """Lengths of the triangles' sides [m], shape (m, 3)."""
    panels: np.ndarray
    """Index of each triangle's panel, shape (m,)."""
    words: str
    """Source of the flat shapes."""
    uv: np.ndarray | None = None
    """Corners of each triangle in the sewing pattern, if there is one, shape (m, 3, 2)."""

    def woven(self, garment: Garment) -> Garment:
        """Return the garment with the warp along +v of the sewing pattern, if there is one."""
        if self.uv is None:
            return garment
        return replace(garment, fibre=along_v(self.uv, garment.unstrained[garment.faces]))


def _pattern(points: np.ndarray, faces: np.ndarray, uv: np.ndarray | None) -> _Pattern:
    """Return the flat shapes from the UV map if it is the sewing pattern, otherwise from the mesh.

    It is the pattern if its scaled edges have nearly the lengths of the mesh's edges.
    """
    worn = side_lengths(points[faces])
    itself = _Pattern(worn, np.zeros(len(faces), dtype=np.int64), "its own shape")
    if uv is None:
        return itself
    drawn = side_lengths(uv)
    if (drawn <= 0.0).any():
        return replace(itself, words=f"{itself.words}, as its UV map has triangles without area")
    panels = panel_numbers(faces, uv)
    scale = float(np.median(worn / drawn))
    along = _scales(worn, uv)
    off = [100 * (scale / each - 1.0) for each in along]
    misses = f"misses the mesh by {off[0]:+.1f} % along u and {off[1]:+.1f} % along v"
    both = uv * along
    if _median_misfit(worn, side_lengths(both)) < 0.01:  # unstretched cloth has the pattern's lengths
        squeezed = max(np.abs(off)) > 0.3  # otherwise both scales count as equal
        words = f"its UV map, a pattern of {panels.max() + 1} panels"
        words += f", which {misses}: each got a scale of its own" if squeezed else ""
        return _Pattern(side_lengths(both) if squeezed else scale * drawn, panels, words, uv)
    if _median_misfit(worn, scale * drawn) > 0.06:
        return replace(itself, words=f"{itself.words}, as its UV map is no pattern of one scale")
    return _Pattern(scale * drawn, panels, f"its UV map, a pattern of {panels.max() + 1} panels, which {misses}", uv)


def _median_misfit(worn: np.ndarray, drawn: np.ndarray) -> float:
    """Return the median relative difference of edges between mesh and pattern."""
    return float(np.median(np.abs(worn / drawn - 1.0)))


def _scales(worn: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return the lengths [m] of one unit of u and of v with which a UV map fits the mesh best, shape (2,).

    With the scales sqrt(a) and sqrt(b), an edge has the squared length a u^2 + b v^2. The fit of a and b minimises the
    relative errors of squared lengths; large errors, as at seams, have less weight.
    """
    across = (np.roll(uv, -2, axis=1) - np.roll(uv, -1, axis=1)).reshape(-1, 2) ** 2
    wanted = worn.ravel() ** 2
    squared = robust_fit(across / wanted[:, None], np.ones((len(wanted), 1)))[:, 0]
    return np.sqrt(np.maximum(squared, 1e-12 * float(squared.max())))


def along_v(uv: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the direction of a UV map's +v axis in triangles of a garment, as unit vectors, shape (m, 3).

    The triangles have the corners `uv` in the pattern, shape (m, 3, 2), and `corners` in the garment, shape (m, 3, 3).
    """
    first, second = (uv[:, k] - uv[:, 0] for k in (1, 2))
    one, other = (corners[:, k] - corners[:, 0] for k in (1, 2))
    # a and b solve first * b + second * a = (0, det), with det the cross product of first and second
    along = first[:, :1] * other - second[:, :1] * one
    turned = np.sign(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])[:, None]
    return turned * along / np.linalg.norm(along, axis=1, keepdims=True)


def _carried(fibre: np.ndarray, old: Garment, new: Garment) -> np.ndarray:
    """Return the warp `fibre` of a flat garment in each triangle of its new mesh, shape (k, 3).

    It is that of the nearest old triangle in the same layer.
    """
    out = np.empty((len(new.faces), 3))
    facing = [facing_down(each.vertices, each.faces) for each in (old, new)]
    for down in (False, True):
        before, after = (np.flatnonzero(each == down) for each in facing)
        if len(after):
            middles = old.vertices[old.faces[before]].mean(axis=1)[:, :2]
            nearest = cKDTree(middles).query(new.vertices[new.faces[after]].mean(axis=1)[:, :2])[1]
            out[after] = fibre[before[nearest]]
    return out
