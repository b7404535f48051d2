"""Makes a garment from a mesh that is flat, with one layer, or with a front that faces up and a back.

A mesh that is not flat is laid flat by simulation: the garment falls on its back onto the table.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from tatamu.base.errors import InputError, SimulationError
from tatamu.garments.garment import Garment
from tatamu.garments.meshfile import border_loops, fold_edges
from tatamu.garments.outline import Outline, divided, named_sides
from tatamu.garments.sewing import front_and_back, one_layer
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import Topology, edge_lengths, twice_areas
from tatamu.simulation.scene import Cloth, Scene, Table
from tatamu.simulation.simulators import simulate


def flat_garment(name: str, plan: np.ndarray, faces: np.ndarray, material: Material) -> Garment:
    """Return the garment of a flat mesh with vertices [m], shape (n, 2), and triangles of consistent orientation.

    Raises:
        InputError: If more than two layers lie on each other.
    """
    faces, up = _facing(plan, faces)
    _check_layers(plan, faces, up)
    above, below = (np.isin(np.arange(len(plan)), faces[side]) for side in (up, ~up))
    t = material.thickness
    height = t * np.where(above & below, 1.0, np.where(above & ~up.all(), 1.5, 0.5))
    plan = plan - 0.5 * (plan.min(axis=0) + plan.max(axis=0))
    loop = _outer_loop(plan, faces[up])
    edges = {side: loop[part] for side, part in named_sides(plan[loop]).items()}
    edges, openings = divided(edges, Topology(faces).border, plan)
    width, length = np.ptp(plan, axis=0)[::-1]
    return Garment(
        name=name,
        size=(float(width), float(length)),
        spacing=typical_edge(plan, faces),
        vertices=np.column_stack([plan, height]),
        faces=faces,
        material=material,
        seams=fold_edges(Topology(faces), up),
        rest=None if up.all() else np.column_stack([plan, np.zeros(len(plan))]),
        edges=edges,
        openings=openings,
    )


def meshed_anew(garment: Garment, spacing: float | None) -> Garment:
    """Return a garment with the same outline and openings, but with a new mesh.

    Raises:
        InputError: If front and back differ, or the outline cannot be meshed.
    """
    plan = garment.vertices[:, :2]
    up = _facing(plan, garment.faces)[1]
    sides = {side: plan[path] for side, path in garment.edges.items()}
    holes = tuple(plan[np.append(hole, hole[0])] for hole in border_loops(garment.faces[up])[1:])
    if up.all():
        outline = Outline(sides, holes=holes)
        made = one_layer(garment.name, outline, garment.material, spacing)
        return replace(made, notes=(*garment.notes, *made.notes))
    around = shapely.Polygon(plan[_outer_loop(plan, garment.faces[~up][:, ::-1])])
    behind = _lower_openings(garment, around)
    lines = {name: sides[name] for name in behind}
    renamed = {f"back {name}" if name in behind else name: behind.get(name, side) for name, side in sides.items()}
    outline = Outline(renamed, lines, holes)
    if around.symmetric_difference(outline.polygon).area > 0.02 * outline.polygon.area:
        raise InputError(
            "remesh: front and back must have the same outline except at the openings, but their areas differ by more "
            "than 2 %; leave remesh out"
        )
    openings = [f"back {name}" if name in behind else name for name in garment.openings]
    made = front_and_back(garment.name, outline, openings, garment.material, spacing)
    return replace(made, notes=(*garment.notes, *made.notes))


def _lower_openings(garment: Garment, back: shapely.Polygon) -> dict[str, np.ndarray]:
    """Return the edges of a garment's back, shape (k, 2), at openings where the front ends lower, such as a neck."""
    plan = garment.vertices[:, :2]
    found = {}
    for name in garment.openings:
        path = garment.edges[name]
        for loop in border_loops(garment.faces):
            if path[0] not in loop or path[-1] not in loop:
                continue
            ring = np.roll(loop, -int(np.flatnonzero(loop == path[0])[0]))
            last = int(np.flatnonzero(ring == path[-1])[0])
            ways = [ring[: last + 1], np.append(ring[last:], ring[0])[::-1]]
            edge = plan[min(ways, key=lambda way: np.isin(way, path).sum())]
            apart = shapely.hausdorff_distance(shapely.LineString(edge), shapely.LineString(plan[path]))
            inside = shapely.contains_xy(back, *plan[path[1:-1]].T).mean() if len(path) > 2 else 0.0
            if apart > garment.spacing and inside > 0.9:
                found[name] = edge
    return found


def typical_edge(points: np.ndarray, faces: np.ndarray) -> float:
    """Return the median length of a mesh's edges [m]."""
    return float(np.median(edge_lengths(points, Topology(faces).edges)))


def _facing(plan: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of a flat mesh, a single layer turned upwards, and whether each faces up, shape (m,)."""
    up = twice_areas(plan, faces) > 0
    return (faces, up) if up.any() else (faces[:, ::-1], ~up)


def _check_layers(plan: np.ndarray, faces: np.ndarray, up: np.ndarray) -> None:
    for side, name in ((up, "up"), (~up, "down")):
        triangles = shapely.polygons(plan[faces[side]])
        # more area than they cover: they lie on each other
        if len(triangles) and shapely.area(triangles).sum() > 1.01 * shapely.union_all(triangles).area:
            raise InputError(
                f"mesh: must have at most one layer that faces {name}, but several lie on top of one another; "
                "remove all but one"
            )


def _outer_loop(plan: np.ndarray, faces: np.ndarray) -> np.ndarray:
    return max(border_loops(faces), key=lambda loop: float(shapely.Polygon(plan[loop]).area))


def laid_flat(name: str, points: np.ndarray, faces: np.ndarray, material: Material) -> Garment:
    """Simulate the fall of a garment onto the table, and return it as it then lies.

    Its vertices [m], shape (n, 3), have x away from the hem and z out of the front. Their shape stays the unstrained
    one.

    Raises:
        InputError: If the simulation of the fall fails, or the garment ends as a heap.
    """
    advice = (
        'if the garment has the wrong orientation, name the axis from hem to top under [garment], such as up = "y"; '
        "otherwise give its pattern as the UV map of an OBJ, or as an outline (SVG, DXF) with openings"
    )
    start = points - [*(0.5 * (points.min(axis=0) + points.max(axis=0)))[:2], points[:, 2].min() - 0.01]
    # so much drag that the garment sinks slowly
    falling = material.model_copy(update={"air_drag": max(2.0, material.air_drag)})
    scene = Scene(cloth=Cloth(vertices=start, faces=faces), material=falling, table=Table(), duration=2.0)
    try:
        lying = simulate(scene).positions[-1]
    except SimulationError as error:
        raise InputError(f"mesh: cannot be laid flat by a simulation ({error}); {advice}") from None
    middle = 0.5 * (lying.min(axis=0) + lying.max(axis=0))
    lying = lying - [middle[0], middle[1], 0.0]
    height = float(lying[:, 2].max())
    if height > 0.04:  # a heap
        most = f"must be at most 40 mm high after a fall on its back, given {1e3 * height:.0f} mm"
        raise InputError(f"mesh: {most}; {advice}")
    note = f"the garment is laid flat by a simulated fall of 2 s on its back, and is then {1e3 * height:.0f} mm high"
    note += "; look at the picture, because the garment is not quite flat" if height > 0.02 else ""
    width, length = np.ptp(lying[:, :2], axis=0)[::-1]
    around = _silhouette(lying, faces)
    sides = {name: around[part] for name, part in named_sides(lying[around, :2]).items()}
    openings = {f"opening {k + 1}": np.append(loop, loop[0]) for k, loop in enumerate(border_loops(faces))}
    return Garment(
        name=name,
        size=(float(width), float(length)),
        spacing=typical_edge(points, faces),
        vertices=lying,
        faces=faces,
        material=material,
        rest=points,
        edges={**sides, **openings},
        openings=tuple(openings),
        notes=(note,),
    )


def _silhouette(lying: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the vertices of the top layer along a garment's outline from above, counter-clockwise, shape (k,)."""
    near = 0.35 * typical_edge(lying, faces)
    around = shapely.union_all(shapely.polygons(lying[faces][..., :2])).buffer(0)
    largest = max(shapely.get_parts(around), key=lambda part: float(part.area))
    ring = shapely.Polygon(largest.exterior).normalize().exterior.reverse()  # normalised rings are clockwise
    places = shapely.points(lying[:, :2])
    close = np.flatnonzero(shapely.distance(places, ring) < near)
    at = shapely.line_locate_point(ring, places[close])
    order = np.argsort(at)
    cell = np.floor(at[order] / (2.0 * near)).astype(int)
    members = [close[order][cell == k] for k in np.unique(cell)]
    return np.array([own[np.argmax(lying[own, 2])] for own in members])
