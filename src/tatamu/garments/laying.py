"""Lays a garment flat by simulation: the garment falls on its back onto the table."""

from __future__ import annotations

import numpy as np
import shapely

from tatamu.base.errors import InputError, SimulationError
from tatamu.garments.flat import typical_edge
from tatamu.garments.garment import Garment
from tatamu.garments.meshfile import border_loops
from tatamu.garments.outline_sides import named_sides
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Cloth, Scene, Table
from tatamu.simulation.simulators import simulate

SECONDS = 2.0
LYING, MAX_HEIGHT = 0.02, 0.04
"""Height of a fallen garment [m] above which a note says so, and above which it is a heap and is refused."""

ADVICE = (
    "if the garment was turned wrongly, write its axis from hem to top as `up` under [garment]; otherwise give its "
    "pattern as the UV map of an OBJ, or as an outline (SVG, DXF) with openings"
)
"""Advice to the user if a mesh cannot be laid flat."""


def laid_flat(name: str, points: np.ndarray, faces: np.ndarray, material: Material) -> Garment:
    """Simulate the fall of a garment onto the table, and return it as it then lies.

    Its vertices [m], shape (n, 3), have x away from the hem and z out of the front. Their shape stays the unstrained
    one.

    Raises:
        InputError: If the simulation of the fall fails, or the garment ends as a heap.
    """
    start = points - [*(0.5 * (points.min(axis=0) + points.max(axis=0)))[:2], points[:, 2].min() - 0.01]
    # so much drag that the garment sinks slowly
    falling = material.model_copy(update={"air_drag": max(2.0, material.air_drag)})
    scene = Scene(cloth=Cloth(vertices=start, faces=faces), material=falling, table=Table(), duration=SECONDS)
    try:
        lying = simulate(scene).positions[-1]
    except SimulationError as error:
        raise InputError(f"mesh: cannot be laid flat by simulation ({error}); {ADVICE}") from None
    middle = 0.5 * (lying.min(axis=0) + lying.max(axis=0))
    lying = lying - [middle[0], middle[1], 0.0]
    height = float(lying[:, 2].max())
    if height > MAX_HEIGHT:
        raise InputError(
            f"mesh: must lie at most {1e3 * MAX_HEIGHT:.0f} mm high after falling on its back, given "
            f"{1e3 * height:.0f} mm; {ADVICE}"
        )
    note = (
        f"laid flat by a simulated fall of {SECONDS:g} s on its back, after which the garment is at most "
        f"{1e3 * height:.0f} mm high"
    )
    if height > LYING:
        note += ", not quite flat; look at the picture"
    width, length = np.ptp(lying[:, :2], axis=0)[::-1]
    edges, openings = _edges(lying, faces)
    return Garment(
        name=name,
        size=(float(width), float(length)),
        spacing=typical_edge(points, faces),
        vertices=lying,
        faces=faces,
        material=material,
        rest=points,
        edges=edges,
        openings=openings,
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
    close = close[order]
    at = at[order]
    cell = np.floor(at / (2.0 * near)).astype(int)
    highest = [members[np.argmax(lying[members, 2])] for k in np.unique(cell) if len(members := close[cell == k])]
    return np.array(highest)


def _edges(lying: np.ndarray, faces: np.ndarray) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    """Return the four sides of the outline from above and the borders of the mesh by name, and the latter's names."""
    around = _silhouette(lying, faces)
    sides = {name: around[part] for name, part in named_sides(lying[around, :2]).items()}
    openings = {f"opening {k + 1}": np.append(loop, loop[0]) for k, loop in enumerate(border_loops(faces))}
    return {**sides, **openings}, tuple(openings)
