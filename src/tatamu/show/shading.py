"""Computes the light on cloth for pictures. The images have linear light and an alpha channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from tatamu.show.palette import BACK, FRONT, REAR, rgb
from tatamu.show.raster import View, Visible, rasterise, vertex_normals

SUN = np.array([-0.35, -0.30, 0.89]) / np.linalg.norm([-0.35, -0.30, 0.89])
"""Unit vector that points towards the light source in pictures, shape (3,)."""


@dataclass(frozen=True)
class PaintedMesh:
    """A triangle mesh whose fronts and backs may have different colours."""

    points: np.ndarray
    """Positions of the vertices [m], shape (n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3)."""
    front: np.ndarray
    """Colour of each triangle's front in linear light, shape (m, 3)."""
    back: np.ndarray
    """Colour of the back of all triangles in linear light, shape (3,)."""
    flat: np.ndarray | None = None
    """Positions on the flat cloth [m], shape (n, 2), for a pattern of lines every 5 cm; None for no lines."""


def cloth(
    points: np.ndarray, faces: np.ndarray, start: np.ndarray | None = None, lower: np.ndarray | None = None
) -> PaintedMesh:
    """Return the mesh of cloth with the colours of its sides.

    Args:
        points: Positions of the vertices [m], shape (n, 3).
        faces: Triangles, shape (m, 3).
        start: Positions on the flat cloth [m], shape (n, 3), for a pattern of lines; None for no lines.
        lower: Whether each triangle belongs to the lower layer, shape (m,); None for a single layer.
    """
    back = np.zeros(len(faces), dtype=bool) if lower is None else lower
    outside = np.where(back[:, None], rgb(REAR), rgb(FRONT))
    return PaintedMesh(points, faces, outside, rgb(BACK), None if start is None else start[:, :2])


def see(view: View, mesh: PaintedMesh) -> tuple[Visible, np.ndarray]:
    """Return what is visible at each pixel, and the depth, -inf at pixels that nothing covers, shape (h, w)."""
    projected = view.project(mesh.points)
    visible = rasterise(projected, mesh.faces, view.shape)
    depth = np.full(view.shape, -np.inf)
    depth[visible.mask] = visible.sample(projected[:, 2], mesh.faces)
    return visible, depth


def shade(view: View, mesh: PaintedMesh, visible: Visible, sunlit: np.ndarray | float = 1.0) -> np.ndarray:
    """Return the linear light of the p pixels that a mesh covers, shape (p, 3); `sunlit` is 0 in shadow, 1 in light."""
    normals = visible.sample(vertex_normals(mesh.points, mesh.faces), mesh.faces)
    normals /= np.maximum(np.sqrt(np.einsum("pk,pk->p", normals, normals)), 1e-12)[:, None]
    eye = view.towards_eye(visible.sample(mesh.points, mesh.faces))
    triangle = visible.covered[0]
    a, b, c = (mesh.points[mesh.faces[:, k]] for k in range(3))
    outwards = np.cross(b - a, c - a)
    facing = (np.einsum("mk,mk->m", outwards, view.towards_eye((a + b + c) / 3.0)) > 0)[triangle]
    normals = np.where((np.einsum("pk,pk->p", normals, eye) > 0)[:, None], normals, -normals)
    colour = np.where(facing[:, None], mesh.front[triangle], mesh.back)
    if mesh.flat is not None:
        squares = visible.sample(mesh.flat, mesh.faces) / 0.05
        off = np.abs(squares - np.rint(squares)).min(axis=1) * 0.05
        threads = np.clip(1.5 - off / 0.0008, 0.0, 1.0)  # 1 on a line, 0 between
        colour = colour * (1.0 - 0.13 * threads)[:, None]
    sky = 0.44 + 0.16 * normals[:, 2]
    return colour * (sky + 0.55 * sunlit * np.maximum(normals @ SUN, 0.0))[:, None]


def occlusion(depth: np.ndarray, ground: float, radius: float, reach: float) -> np.ndarray:
    """Return how much lower each pixel is than its surroundings, from 0 to 1 at `reach` [m], shape (h, w).

    Darkened pixels show the edges of flat layers, whose heights differ by a millimetre (Luft, Colditz and Deussen 2006,
    depth darkening). The surroundings have a radius in pixels; -inf in `depth` is the ground.
    """
    height = np.maximum(depth, ground)
    return np.clip((gaussian_filter(height, radius, mode="nearest") - height) / reach, 0.0, 1.0)


def shrink(image: np.ndarray, times: int) -> np.ndarray:
    """Reduce an image with premultiplied alpha by averaging blocks of `times` x `times` pixels, shape (h, w, 4)."""
    height, width = image.shape[0] // times, image.shape[1] // times
    blocks = image[: height * times, : width * times].reshape(height, times, width, times, 4)
    return blocks.mean(axis=(1, 3))


def to_pixels(image: np.ndarray) -> np.ndarray:
    """Return an image of linear light and premultiplied alpha as uint8 pixels of straight alpha, shape (h, w, 4)."""
    alpha = image[..., 3:]
    colour = np.clip(image[..., :3] / np.maximum(alpha, 1e-6), 0.0, 1.0) ** (1 / 2.2)
    return (np.concatenate([colour, np.clip(alpha, 0.0, 1.0)], axis=-1) * 255.0 + 0.5).astype(np.uint8)
