"""Patterns as CAD and drawing programs write them, written into a folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np

MM = {"METRIC": 1.0, "ENGLISH": 25.4}
HALF = [(0, -160), (310, -160), (262, -228), (352, -270), (432, -132), (460, -68)]
SHIRT = np.array([*HALF, (405, 0), *((x, -y) for x, y in reversed(HALF))])
"""A T-shirt front [mm]: its grain along x, the hem at x = 0, as pattern programs lay it."""
BACK = SHIRT + np.where((SHIRT == [405, 0]).all(axis=1)[:, None], [40, 0], [0, 0])
SLEEVE = np.array([[0, -110], [0, 110], [100, 90], [140, 0], [100, -90]])


class Tags:
    """A DXF file, tag by tag, of the release that the standard asks for, without a header."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, *tags: tuple[int, object]) -> None:
        for code, value in tags:
            self.lines += [str(code), f"{value:.6f}" if isinstance(value, float) else str(value)]

    def text(self, words: str, layer: int = 1) -> None:
        self.add((0, "TEXT"), (8, layer), (10, 0.0), (20, 0.0), (40, 5.0), (1, words))

    def line(self, start: np.ndarray, end: np.ndarray, layer: int) -> None:
        self.add((0, "LINE"), (8, layer), (10, float(start[0])), (20, float(start[1])))
        self.add((11, float(end[0])), (21, float(end[1])))

    def points(self, places: np.ndarray, layer: int) -> None:
        for x, y in places:
            self.add((0, "POINT"), (8, layer), (10, float(x)), (20, float(y)))

    def polyline(self, points: np.ndarray, layer: int, closed: bool = True) -> None:
        self.add((0, "POLYLINE"), (8, layer), (66, 1), (70, int(closed)))
        for x, y in points:
            self.add((0, "VERTEX"), (8, layer), (10, float(x)), (20, float(y)))
        self.add((0, "SEQEND"))


def block(tags: Tags, name: str, size: str, outline: np.ndarray, unit: float, seam: float = 0.0) -> None:
    """A piece with all that a pattern has: points, notches, grain line, an internal line, perhaps a seam allowance."""
    outline = outline / unit
    middle, reach = outline.mean(axis=0), np.ptp(outline, axis=0)
    tags.add((0, "BLOCK"), (8, 0), (2, f"{name}-{size}"), (70, 64), (10, 0.0), (20, 0.0))
    for words in (f"Piece Name: {name}", f"Size: {size}", "Annotation: CUT 1", "Quantity: 1"):
        tags.text(words)
    if seam:
        import shapely

        wider = shapely.Polygon(outline).buffer(seam / unit, join_style="mitre").exterior.coords[:-1]
        tags.polyline(np.array(wider), 1)
        tags.polyline(outline, 14)
    else:
        tags.polyline(outline, 1)
    tags.points(outline, 2)
    tags.points(outline[[1, 3]], 4)
    tags.line(outline[1], outline[1] + 0.02 * reach, 4)
    along = np.array([0.3 * reach[0], 0.0])
    tags.line(middle - along, middle + along, 7)
    tags.polyline(middle + 0.1 * reach * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), 8)  # a pocket is placed there
    tags.polyline(outline, 84)
    tags.add((0, "ENDBLK"))


def aama_dxf(folder: Path, units: str = "METRIC", seam: float = 0.0, name: str = "shirt.dxf") -> Path:
    """Front, back and sleeve of a T-shirt in one file."""
    tags = Tags()
    tags.add((0, "SECTION"), (2, "BLOCKS"))
    for piece, outline in (("FRONT", SHIRT), ("BACK", BACK), ("SLEEVE", SLEEVE)):
        block(tags, piece, "M", outline, MM[units], seam)
    tags.add((0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))
    for words in ("ASTM/D13Proposal 1 Version: D 6673-04", "Author: Own", "Sample Size: M", f"Units: {units}"):
        tags.text(words)
    for piece in ("FRONT", "BACK", "SLEEVE"):
        tags.add((0, "INSERT"), (8, 1), (2, f"{piece}-M"), (10, 0.0), (20, 0.0))
    tags.add((0, "ENDSEC"), (0, "EOF"))
    (folder / name).write_text("\n".join(tags.lines) + "\n", encoding="ascii")
    return folder / name


def inserted_dxf(folder: Path, insunits: int, metres: float) -> Path:
    """One piece in a block, as a program of another trade would write it: no text, its unit in the header."""
    import ezdxf

    document = ezdxf.new("R2010")  # type: ignore[attr-defined]
    document.units = insunits
    made = document.blocks.new("FRONT")
    made.add_lwpolyline(SHIRT * 1e-3 / metres, close=True, dxfattribs={"layer": "1"})
    made.add_line((0.1 / metres, 0), (0.3 / metres, 0), dxfattribs={"layer": "7"})
    made.add_circle((0.2 / metres, 0), 0.02 / metres, dxfattribs={"layer": "8"})
    document.modelspace().add_blockref("FRONT", (3.0 / metres, 2.0 / metres))
    document.saveas(folder / "front.dxf")
    return folder / "front.dxf"


def half_dxf(folder: Path) -> Path:
    """Half a back, to be cut on the fold."""
    tags, half = Tags(), SHIRT[:7]
    tags.add((0, "SECTION"), (2, "BLOCKS"), (0, "BLOCK"), (8, 0), (2, "BACK"), (70, 64), (10, 0.0), (20, 0.0))
    tags.polyline(np.vstack([half, [[0, 0]]]), 1)
    tags.line(np.array([405, 0]), np.array([0, 0]), 6)
    tags.add((0, "ENDBLK"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))
    tags.text("UNITS: METRIC")
    tags.add((0, "INSERT"), (8, 1), (2, "BACK"), (10, 0.0), (20, 0.0), (0, "ENDSEC"), (0, "EOF"))
    (folder / "half.dxf").write_text("\n".join(tags.lines) + "\n", encoding="ascii")
    return folder / "half.dxf"


HOODIE = (
    "M 150 60 L 260 0 L 360 0 L 470 60 L 620 460 L 540 490 L 450 250 L 450 710 L 170 710 L 170 250 L 80 490 L 0 460 Z"
)
"""620 wide and 710 long."""
INKSCAPE = 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" inkscape:version="{version}"'
ILLUSTRATOR = "<!-- Generator: Adobe Illustrator 27.0.0, SVG Export Plug-In . SVG Version: 6.00 Build 0)  -->"


def hoodie_svg(head: str, body: str = "", comment: str = "", scale: float = 1.0) -> str:
    """A hoodie whose coordinates are millimetres times `scale`."""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>{comment}<svg xmlns="http://www.w3.org/2000/svg" {head}>'
        f'<g transform="scale({scale})"><path id="path812" d="{HOODIE}"/>{body}</g></svg>'
    )


POCKET = '<path id="path815" d="M 210 600 L 260 480 L 360 480 L 410 600"/><path id="path-9-3" d="M 310 0 L 310 710"/>'
"""A pocket's line and the middle of the front, which nobody named."""
NAMED = '<path id="line4" inkscape:label="hem" d="M 170 710 L 450 710"/>'
