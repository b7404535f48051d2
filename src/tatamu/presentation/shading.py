"""Light on cloth: from a view of triangles to an image of linear light with alpha."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from tatamu.presentation.palette import BACK, FRONT, REAR, rgb
from tatamu.presentation.raster import View, Visible, rasterise, vertex_normals

SUN = np.array([-0.35, -0.30, 0.89]) / np.linalg.norm([-0.35, -0.30, 0.89])
"""Direction towards the light, unit vector, shape (3,)."""


@dataclass(frozen=True)
class PaintedMesh:
    """A triangle mesh with one colour for each of its sides."""

    points: np.ndarray
    """[m], shape (n, 3)."""
    faces: np.ndarray
    """Shape (m, 3)."""
    front: np.ndarray
    """Linear light of each triangle, shape (m, 3)."""
    back: np.ndarray
    """Linear light, shape (3,)."""
    flat: np.ndarray | None = None
    """Places on the flat cloth [m], shape (n, 2), at which lines are drawn every 5 cm; None for no lines."""


def cloth(
    points: np.ndarray, faces: np.ndarray, start: np.ndarray | None = None, lower: np.ndarray | None = None
) -> PaintedMesh:
    """The cloth in its colours, with the lines of its flat `start` (n, 3); a `lower` triangle (m,) is of the back."""
    back = np.zeros(len(faces), dtype=bool) if lower is None else lower
    outside = np.where(back[:, None], rgb(REAR), rgb(FRONT))
    return PaintedMesh(points, faces, outside, rgb(BACK), None if start is None else start[:, :2])


def see(view: View, mesh: PaintedMesh) -> tuple[Visible, np.ndarray]:
    """Find the visible triangles of a mesh and the depth of every pixel, -inf if it has none, shape (h, w)."""
    projected = view.project(mesh.points)
    visible = rasterise(projected, mesh.faces, view.shape)
    depth = np.full(view.shape, -np.inf)
    depth[visible.mask] = visible.sample(projected[:, 2], mesh.faces)
    return visible, depth


def shade(view: View, mesh: PaintedMesh, visible: Visible, sunlit: np.ndarray | float = 1.0) -> np.ndarray:
    """Linear light of the covered pixels, shape (p, 3); `sunlit`: 0 in shadow to 1, shape (p,)."""
    normals = visible.sample(vertex_normals(mesh.points, mesh.faces), mesh.faces)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    eye = view.towards_eye(visible.sample(mesh.points, mesh.faces))
    triangle = visible.covered[0]
    facing = _facing(view, mesh)[triangle]
    normals = np.where((np.einsum("pk,pk->p", normals, eye) > 0)[:, None], normals, -normals)
    colour = np.where(facing[:, None], mesh.front[triangle], mesh.back)
    if mesh.flat is not None:
        colour = colour * (1.0 - 0.13 * _threads(visible.sample(mesh.flat, mesh.faces)))[:, None]
    sky = 0.44 + 0.16 * normals[:, 2]
    return colour * (sky + 0.55 * sunlit * np.maximum(normals @ SUN, 0.0))[:, None]


def _threads(flat: np.ndarray) -> np.ndarray:
    """Return the intensity of a pattern with lines every 5 cm, 1 on a line and 0 between, for places (p, 2) [m]."""
    off = np.abs(flat / 0.05 - np.rint(flat / 0.05)).min(axis=1) * 0.05
    return np.clip(1.5 - off / 0.0008, 0.0, 1.0)


def _facing(view: View, mesh: PaintedMesh) -> np.ndarray:
    """Find the triangles that show their front, shape (m,)."""
    a, b, c = (mesh.points[mesh.faces[:, k]] for k in range(3))
    return np.einsum("mk,mk->m", np.cross(b - a, c - a), view.towards_eye((a + b + c) / 3.0)) > 0


def occlusion(depth: np.ndarray, ground: float, radius: float, reach: float) -> np.ndarray:
    """Measure how much lower a pixel lies than its surroundings, 0 to 1 at `reach`, shape (h, w).

    The heights of flat layers differ by a millimetre. Darkening pixels that are lower than their neighbours makes them
    visible (Luft, Colditz and Deussen 2006, depth darkening).

    Args:
        depth: Height of each pixel [m], -inf if there is only ground.
        ground: Height of the ground [m].
        radius: Radius of the neighbourhood [pixels].
        reach: Height difference that counts as full shadow [m].
    """
    height = np.maximum(depth, ground)
    return np.clip((gaussian_filter(height, radius, mode="nearest") - height) / reach, 0.0, 1.0)


def shrink(image: np.ndarray, times: int) -> np.ndarray:
    """Average blocks of `times` x `times` pixels of an image with premultiplied alpha, (h, w, 4)."""
    height = image.shape[0] // times
    width = image.shape[1] // times
    blocks = image[: height * times, : width * times].reshape(height, times, width, times, 4)
    return blocks.mean(axis=(1, 3))


def to_pixels(image: np.ndarray) -> np.ndarray:
    """Bytes with straight alpha, (h, w, 4), from linear light with premultiplied alpha."""
    alpha = image[..., 3:]
    colour = np.clip(image[..., :3] / np.maximum(alpha, 1e-6), 0.0, 1.0) ** (1 / 2.2)
    return (np.concatenate([colour, np.clip(alpha, 0.0, 1.0)], axis=-1) * 255.0 + 0.5).astype(np.uint8)
