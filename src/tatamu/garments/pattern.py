"""Makes a garment from an outline, which is a drawing or a piece of a sewing pattern."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from tatamu.base.errors import InputError
from tatamu.garments.cut import cut
from tatamu.garments.description import GarmentFile
from tatamu.garments.dxf import read_dxf
from tatamu.garments.frame import direction, plane_turn
from tatamu.garments.garment import Garment
from tatamu.garments.outline import counted
from tatamu.garments.pieces import chosen
from tatamu.garments.sewing import front_and_back, one_layer
from tatamu.garments.svg import read_svg
from tatamu.garments.units import check_size_of_file, doubts
from tatamu.simulation.material import Material

READERS = {".svg": read_svg, ".dxf": read_dxf}
"""Function that reads each drawing format, by the file name's ending."""
ONE_LAYER = "one layer, as no opening is named: give openings under [garment] for a front and a back, or layers = 1"
"""Note to the user on a closed outline for which no openings were given."""


def from_outline(given: GarmentFile, source: Path, material: Material) -> Garment:
    """Make the garment of an SVG or DXF file."""
    reader = READERS.get(source.suffix.lower())
    if reader is None:
        raise InputError(f"outline: must be one of {', '.join(READERS)}")
    drawing = reader(source)
    unit = drawing.unit.scaled(given.scale)
    piece = chosen(drawing, given.piece, unit.metres, source)
    openings = given.openings
    if isinstance(openings, dict) and source.suffix.lower() == ".svg":  # y points down in SVG files, but up in curves
        openings = {name: [(x, -y) for x, y in curve] for name, curve in openings.items()}
    turn = plane_turn(given.up or "y", piece.grain if given.grain else None)
    try:
        made = cut(piece, unit.metres * turn, openings, source, given.holes)
    except InputError as error:
        raise InputError(f'{error}; piece "{piece.name}"' if len(drawing.pieces) > 1 else str(error)) from None
    if given.size is None:
        check_size_of_file(made.outline.size, f"outline: {piece.name}", unit)
    outline = made.outline.fitted(given.size)
    notes = [*made.notes, *_turn_note(turn, given.up or "y")]
    notes += [] if given.size else doubts(made.outline.size, unit)
    if given.layers == 2 or (given.layers is None and made.openings):
        garment = front_and_back(given.name, outline, made.openings, material, given.spacing)
    else:
        garment = one_layer(given.name, outline, material, given.spacing)
        notes += [ONE_LAYER] if given.layers is None else []
    if piece.grain is not None and not given.grain:  # the piece is not turned, but the warp follows the grain line
        garment = replace(garment, fibre=np.array([[*(turn @ piece.grain), 0.0]]))
    notes += _hole_note(garment)
    return replace(garment, reading=unit.reading(given.size), notes=(*notes, *garment.notes))


def _hole_note(garment: Garment) -> list[str]:
    paths = [path for name, path in garment.edges.items() if name.startswith("hole ")]
    if not paths:
        return []
    holes = [shapely.Polygon(garment.unstrained[path, :2]) for path in paths]
    return [f"{counted(holes, 'hole')}, where closed curves lie inside the outline (holes = false leaves them out)"]


def _turn_note(turn: np.ndarray, up: str) -> list[str]:
    ahead = turn @ direction(up)[:2]
    degrees = round(float(np.degrees(np.arctan2(ahead[1], ahead[0]))), 1)
    if abs(degrees) < 0.1:
        return []
    return [f"turned by {degrees:g} degrees so that its grain line points away from the hem (grain = false leaves it)"]
