"""Outlines and meshes of garments as others make them, written into a folder."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import trimesh

from tatamu.simulation.mesh.meshing import staggered_rectangle

TSHIRT = (
    "M 220 0 C 240 40 300 40 320 0 L 400 30 L 540 110 L 500 190 L 430 150 L 430 460 "
    "L 110 460 L 110 150 L 40 190 L 0 110 L 140 30 Z"
)


def svg(body: str, width: float = 540, height: float = 460) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" '
        f'viewBox="0 0 {width} {height}">{body}</svg>'
    )


def written(folder: Path, name: str, text: str) -> Path:
    """The path of a file with a text."""
    (folder / name).write_text(text)
    return folder / name


def meshed(folder: Path, name: str, vertices: np.ndarray, faces: np.ndarray) -> Path:
    """The path of a file with a mesh, in the format of the name's ending."""
    trimesh.Trimesh(vertices, faces, process=False).export(folder / name)
    return folder / name


def apron_svg(folder: Path) -> Path:
    """One layer with curved sides."""
    outline = "M 100 0 L 300 0 C 300 120 380 150 400 160 L 400 500 L 0 500 L 0 160 C 20 150 100 120 100 0 Z"
    return written(folder, "apron.svg", svg(f'<path d="{outline}"/>'))


def tshirt_svg(folder: Path) -> Path:
    """Two layers: open where lines with names lie on the outline."""
    openings = (
        '<line id="hem" x1="110" y1="460" x2="430" y2="460"/>'
        '<path id="neck" d="M 220 0 C 240 40 300 40 320 0"/>'
        '<polyline id="cuff_l" points="0,110 40,190"/><polyline id="cuff_r" points="540,110 500,190"/>'
    )
    return written(folder, "shirt.svg", svg(f'<path id="outline" d="{TSHIRT}"/>{openings}'))


def pillowcase_dxf(folder: Path) -> Path:
    """Two layers from lines on one layer of a DXF in centimetres, open along a line on another."""
    import ezdxf

    document = ezdxf.new()  # type: ignore[attr-defined]
    document.units = 5
    space = document.modelspace()
    corners = [(0, 0), (40, 0), (40, 60), (0, 60), (0, 0)]
    for start, end in pairwise(corners):
        space.add_line(start, end, dxfattribs={"layer": "cut"})
    space.add_line((0, 0), (40, 0), dxfattribs={"layer": "mouth"})
    path = folder / "pillowcase.dxf"
    document.saveas(path)
    return path


def skirt_toml(folder: Path) -> Path:
    """Two layers; openings given by points in the garment file; lying on its side in the drawing."""
    written(folder, "skirt.svg", svg('<polygon points="0,80 400,0 400,400 0,320"/>', 400, 400))
    openings = "openings = {waist = [[0, 80], [0, 320]], hem = [[400, 0], [400, 400]]}"
    text = f'[garment]\noutline = "skirt.svg"\nup = "-x"\nfabric = "denim"\n{openings}\n'
    return written(folder, "skirt.toml", text)


def cloth_obj(folder: Path) -> Path:
    """A flat mesh in millimetres."""
    vertices, faces = staggered_rectangle(0.3, 0.4, 0.011)
    meshed(folder, "cloth.obj", vertices * 1e3, faces)
    text = '[garment]\nname = "tea towel"\nmesh = "cloth.obj"\nscale = 0.001\nup = "x"\n'
    return written(folder, "cloth.toml", text)


def disc_stl(folder: Path) -> Path:
    """A round table mat, every corner of every triangle a vertex of its own; far too coarse, to be meshed anew."""
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rim = 0.2 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    faces = np.array([[0, 1 + k, 1 + (k + 1) % 24] for k in range(24)])
    meshed(folder, "mat.stl", np.vstack([[0, 0, 0], rim]), faces)
    return written(folder, "mat.toml", '[garment]\nmesh = "mat.stl"\nremesh = true\n')


def bag_ply(folder: Path) -> Path:
    """A front and a back, sewn on three sides, flat on the floor of a world whose y is up."""
    from tatamu.garments.outline import Outline
    from tatamu.garments.sewing import front_and_back
    from tatamu.simulation.presets import load_preset

    corners = np.array([[0, 0], [0.3, 0], [0.3, 0.25], [0, 0.25]])
    sides = {name: corners[[k, (k + 1) % 4]] for k, name in enumerate(("right", "top", "left", "mouth"))}
    bag = front_and_back("bag", Outline(sides), ["mouth"], load_preset("jersey").material, 0.011)
    x, y, z = bag.vertices.T
    return meshed(folder, "bag.ply", np.column_stack([-y, z, -x]), bag.faces)


def tube_glb(folder: Path) -> Path:
    """A tube as a body would wear it: not flat; y is up."""
    around, along = 52, 28
    angle = np.arange(around) * 2 * np.pi / around
    rows = []
    for k in range(along + 1):
        turn = angle + (k % 2) * np.pi / around
        rows.append(np.column_stack([0.11 * np.cos(turn), np.full(around, 0.011 * k), 0.05 * np.sin(turn)]))
    faces = []
    for k in range(along):
        for j in range(around):
            a, b = k * around + j, k * around + (j + 1) % around
            c, d = a + around, b + around
            faces += [[a, d, b], [a, c, d]] if k % 2 else [[a, c, b], [b, c, d]]
    return meshed(folder, "tube.glb", np.vstack(rows), np.array(faces))


GOOD: dict[str, Callable[[Path], Path]] = {
    function.__name__: function
    for function in (apron_svg, tshirt_svg, pillowcase_dxf, skirt_toml, cloth_obj, disc_stl, bag_ply, tube_glb)
}


def crossing_svg(folder: Path) -> Path:
    return written(folder, "bow.svg", svg('<polygon points="0,0 400,400 400,0 0,300"/>', 400, 400))


def open_svg(folder: Path) -> Path:
    return written(folder, "open.svg", svg('<polyline points="0,0 400,0 400,400 0,400"/>', 400, 400))


def fin_obj(folder: Path) -> Path:
    """A cloth with a fin: an edge with three triangles."""
    vertices, faces = staggered_rectangle(0.3, 0.4, 0.02)
    middle = int(np.argmin(np.linalg.norm(vertices, axis=1)))
    face = faces[(faces == middle).any(axis=1)][0]
    fin = np.array([[face[0], face[1], len(vertices)]])
    return meshed(folder, "fin.obj", np.vstack([vertices, [0, 0, 0.01]]), np.vstack([faces, fin]))


def inverted_ply(folder: Path) -> Path:
    """Some triangles face the other way."""
    vertices, faces = staggered_rectangle(0.3, 0.4, 0.02)
    faces[10:20] = faces[10:20, ::-1]
    return meshed(folder, "inverted.ply", vertices, faces)


def millimetres_obj(folder: Path) -> Path:
    vertices, faces = staggered_rectangle(0.3, 0.4, 0.02)
    return meshed(folder, "huge.obj", vertices * 1e3, faces)


def unwelded_obj(folder: Path) -> Path:
    vertices, faces = staggered_rectangle(0.3, 0.4, 0.02)
    return meshed(folder, "soup.obj", vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3))


def two_pieces_svg(folder: Path) -> Path:
    rectangles = '<rect width="200" height="400"/><rect x="300" width="200" height="300"/>'
    return written(folder, "pieces.svg", svg(rectangles))


BROKEN: dict[str, tuple[Callable[[Path], Path], str]] = {
    "crossing": (crossing_svg, "must not cross or touch itself"),
    "open": (open_svg, "must be a closed curve"),
    "fin": (fin_obj, "edges with more than two triangles"),
    "inverted": (inverted_ply, "the orientation is not consistent"),
    "millimetres": (millimetres_obj, "give scale"),
    "unwelded": (unwelded_obj, "weld = true"),
    "pieces": (two_pieces_svg, "must be a single piece, given 2 pieces"),
}
