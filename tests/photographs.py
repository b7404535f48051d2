"""Rendered photographs of cloth and a board on a table: perspective, a lens, light, shadow, grain, blur and noise.

Every pixel is the mean of several rays. The cloth is a slab: its mid-surface, half a thickness up and down, its rim.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from tatamu.cameras import opencv
from tatamu.cameras.board import DOTS, PAPERS, Board, page
from tatamu.cameras.camera import Camera
from tatamu.cameras.pose import Pose
from tatamu.show.raster import vertex_normals
from tatamu.simulation.mesh.topology import Topology
from tatamu.simulation.mesh.zbuffer import z_buffer

WOOD, WHITE, BLUE, GREY = (150, 110, 75), (236, 236, 232), (60, 90, 170), (120, 120, 120)
COARSER = 4
"""Dots of the printed page that are taken together."""
SHADOW_PIXEL = 0.001
"""Resolution of shadows [m]."""


@dataclass(frozen=True)
class Cloth:
    """Cloth on the table, in the board's frame."""

    points: np.ndarray
    """Mid-surface [m], shape (n, 3)."""
    faces: np.ndarray
    thickness: float = 0.002
    colour: tuple[int, int, int] = BLUE
    other: tuple[int, int, int] | None = None
    """Colour of the triangles in `part`; None for one colour."""
    part: np.ndarray | None = None
    """Triangles of the other colour, shape (m,)."""


@dataclass(frozen=True)
class Shot:
    """How a photograph is taken."""

    size: tuple[int, int] = (1600, 1200)
    """Width and height [pixels]."""
    focal: float = 0.8
    """Focal length in widths."""
    distortion: tuple[float, float] = (0.0, 0.0)
    """k1, k2."""
    tilt: float = 20.0
    """Angle from straight down [degrees]."""
    azimuth: float = -90.0
    """Direction from which it is taken, from +x [degrees]."""
    roll: float = 0.0
    """Turn about the optical axis [degrees]."""
    distance: float = 1.3
    """From the point looked at [m]."""
    target: tuple[float, float] = (0.0, 0.0)
    """Point that is looked at [m]."""
    table: tuple[int, int, int] = WOOD
    noise: float = 3.0
    """Standard deviation [8-bit levels]."""
    blur: float = 0.6
    """Standard deviation [pixels]."""
    sun: tuple[float, float, float] = (-0.5, 0.3, 0.8)
    """Direction to the light."""
    seed: int = 0
    finer: int = 2
    """Rays along each side of a pixel."""

    def camera(self) -> Camera:
        """Return the camera."""
        tilt, azimuth, roll = np.radians([self.tilt, self.azimuth, self.roll])
        near = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        up = np.cross(near, right)
        right, up = np.cos(roll) * right + np.sin(roll) * up, np.cos(roll) * up - np.sin(roll) * right
        rotation = np.vstack([right, -up, -near])
        eye = np.array([*self.target, 0.0]) + self.distance * near
        wide, tall = self.size
        focal = self.focal * wide
        matrix = np.array([[focal, 0, 0.5 * wide - 0.5], [0, focal, 0.5 * tall - 0.5], [0, 0, 1]])
        turn = opencv().Rodrigues(rotation)[0].ravel()
        return Camera(matrix, np.array([*self.distortion, 0, 0, 0]), turn, -rotation @ eye)


@dataclass(frozen=True)
class Paper:
    """A page of a board, or a plain sheet, on the table."""

    board: Board | None = field(default_factory=Board)
    """None for a plain sheet."""
    number: int = 0
    pose: Pose = field(default_factory=Pose)
    size: tuple[float, float] = PAPERS["a4"]
    """Of a plain sheet, whose frame has its origin in the middle [m]."""

    def paint(self, colour: np.ndarray, x: np.ndarray, y: np.ndarray) -> None:
        """Paint the paper over the colours (h, w, 3) of places x, y on the table, (h, w) each."""
        near = np.hypot(x - self.pose.x, y - self.pose.y) < 0.4
        own = self.pose.seen_from(np.column_stack([x[near], y[near]]))
        if self.board is None:
            inside = (np.abs(own) <= 0.5 * np.array(self.size)).all(axis=1)
            shade = np.full(len(own), 0.93)
        else:
            coarse = _printed(self.board, self.number)
            dots = DOTS / COARSER / self.board.scale
            rim = self.board.rim
            column, row = (own[:, 0] - rim[0, 0]) * dots - 0.5, (rim[2, 1] - own[:, 1]) * dots - 0.5
            inside = (column > 0) & (row > 0) & (column < coarse.shape[1] - 1) & (row < coarse.shape[0] - 1)
            shade = 0.06 + 0.87 * _looked_up(coarse, column, row)
        colour[near] = np.where(inside[:, None], 250.0 * shade[:, None], colour[near])


@cache
def _printed(board: Board, number: int) -> np.ndarray:
    return np.asarray(page(board, number).reduce(COARSER), dtype=np.float32) / 255.0


def photograph(shot: Shot, cloth: Cloth | None, papers: tuple[Paper, ...] = (Paper(),)) -> np.ndarray:
    """Render a photograph: 8-bit RGB, shape (h, w, 3)."""
    random = np.random.default_rng(shot.seed)
    camera = shot.camera()
    wide, tall = (shot.finer * side for side in shot.size)
    rows, columns = np.mgrid[0 : shot.size[1], 0 : shot.size[0]]
    coarse = camera.on_table(np.column_stack([columns.ravel(), rows.ravel()])).reshape(*rows.shape, 2)
    table = opencv().resize(coarse.astype(np.float32), (wide, tall), interpolation=opencv().INTER_LINEAR)
    x, y = table[..., 0], table[..., 1]
    colour = _grain(x, y, random)[..., None] * np.array(shot.table, dtype=np.float32)
    for paper in papers:
        paper.paint(colour, x, y)
    sun = np.array(shot.sun) / np.linalg.norm(shot.sun)
    light = np.full((tall, wide), sun[2], dtype=np.float32)
    if cloth is not None:
        slab, faces, painted = _slab(cloth)
        seen = camera.project(slab)
        depth = 1.0 / ((slab - camera.eye) @ -camera.rotation[2] * -1.0)
        found = z_buffer(np.column_stack([(seen + 0.5) * shot.finer, depth]), faces, (wide, tall), 1e-9)
        on = found.face.T >= 0
        face, weights = found.face.T[on], found.weights.transpose(1, 0, 2)[on]
        corners = faces[face]
        places = np.einsum("pc,pck->pk", weights, slab[corners])
        normals = np.einsum("pc,pck->pk", weights, vertex_normals(slab, faces)[corners])
        light[on] = np.abs(normals @ sun)
        weave = 1.0 + 0.05 * _noise(places[:, 0], places[:, 1], 0.004, random)
        colour[on] = painted[face] * weave[:, None]
        near = (np.hypot(x - slab[:, 0].mean(), y - slab[:, 1].mean()) < 1.0) & ~on
        lying = np.column_stack([x[near], y[near], np.zeros(near.sum())])
        shadows = _Shadows(slab, faces, sun)
        light[near] *= shadows.sunlit(lying)
        light[on] *= shadows.sunlit(places)
    right = np.linspace(-0.5, 0.5, wide, dtype=np.float32)[None]
    down = np.linspace(-0.5, 0.5, tall, dtype=np.float32)[:, None]
    bright = (0.42 + 0.62 * light) * (1.0 - 0.10 * right - 0.12 * down)
    small = (
        (colour * bright[..., None]).reshape(shot.size[1], shot.finer, shot.size[0], shot.finer, 3).mean(axis=(1, 3))
    )
    blurred = opencv().GaussianBlur(small, (0, 0), shot.blur)
    noise = random.normal(0.0, shot.noise, blurred.shape)
    return np.clip(blurred + noise, 0, 255).astype(np.uint8)


def laid(points: np.ndarray, faces: np.ndarray, pose: Pose, **looks: object) -> Cloth:
    """Return cloth given in its own frame, at a pose in the board's frame."""
    placed = np.column_stack([pose.place(points[:, :2]), points[:, 2]])
    return replace(Cloth(placed, faces), **looks)  # type: ignore[arg-type]


def _slab(cloth: Cloth) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, triangles and their colours of cloth with its thickness."""
    points, faces, count = cloth.points, cloth.faces, len(cloth.points)
    up = np.array([0.0, 0.0, 0.5 * cloth.thickness])
    border = Topology(faces).border
    walls = np.concatenate(
        [np.column_stack([border, border[:, :1] + count]), np.column_stack([border + count, border[:, 1:]])]
    )
    colours = np.tile(np.array(cloth.colour, dtype=float), (len(faces), 1))
    if cloth.part is not None and cloth.other is not None:
        colours[cloth.part] = cloth.other
    rim = np.tile(np.array(cloth.colour, dtype=float), (len(walls), 1))
    if cloth.part is not None and cloth.other is not None:
        beside = {int(v) for v in faces[cloth.part].ravel()}
        rim[[int(w[0]) % count in beside for w in walls]] = cloth.other
    return (
        np.concatenate([points + up, points - up]),
        np.concatenate([faces, faces + count, walls]),
        np.concatenate([colours, colours, rim]),
    )


class _Shadows:
    """Heights of cloth as the sun sees it."""

    def __init__(self, slab: np.ndarray, faces: np.ndarray, sun: np.ndarray) -> None:
        self._across = np.eye(3)[:2] - np.outer(sun[:2] / sun[2], [0.0, 0.0, 1.0])  # down to the table along the light
        flat = slab @ self._across.T
        self._low = flat.min(axis=0) - 0.02
        wide, tall = ((flat.max(axis=0) + 0.02 - self._low) / SHADOW_PIXEL).astype(int)
        grid = np.column_stack([(flat - self._low) / SHADOW_PIXEL, slab[:, 2]])
        heights = z_buffer(grid, faces, (int(wide), int(tall))).heights.T
        self._heights = np.where(np.isfinite(heights), heights, -1.0).astype(np.float32)

    def sunlit(self, places: np.ndarray) -> np.ndarray:
        """Return 1 in the light to 0 in the shadow, for places (k, 3)."""
        column, row = ((places @ self._across.T - self._low) / SHADOW_PIXEL - 0.5).T
        shaded = np.zeros(len(places))
        for dx, dy in ((0, 0), (1.5, 0), (-1.5, 0), (0, 1.5), (0, -1.5)):  # a penumbra
            above = _looked_up(self._heights, column + dx, row + dy, nearest=True)
            shaded += above > places[:, 2] + 0.0012
        return 1.0 - shaded / 5.0


def _grain(x: np.ndarray, y: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return the brightness of wood at places on the table."""
    return 1.0 + 0.10 * _noise(0.15 * x, y, 0.006, random) + 0.05 * _noise(x, y, 0.15, random)


def _noise(x: np.ndarray, y: np.ndarray, scale: float, random: np.random.Generator) -> np.ndarray:
    """Return smooth noise of about unit deviation at places x, y."""
    lattice = random.normal(size=(512, 512)).astype(np.float32)
    return 1.5 * _looked_up(lattice, (x / scale + 200.0) % 510, (y / scale + 200.0) % 510)


def _looked_up(picture: np.ndarray, column: np.ndarray, row: np.ndarray, nearest: bool = False) -> np.ndarray:
    """Return a picture's values at places; -1 outside."""
    cv2 = opencv()
    flat = column.ndim == 1
    count = len(column)
    if flat:  # pictures of OpenCV have limited sides
        room = (-count) % 4096
        column, row = (np.pad(each, (0, room)).reshape(-1, 4096) for each in (column, row))
    maps = column.astype(np.float32), row.astype(np.float32)
    how = cv2.INTER_NEAREST if nearest else cv2.INTER_LINEAR
    found = cv2.remap(picture, *maps, how, borderMode=cv2.BORDER_CONSTANT, borderValue=-1.0)
    return found.ravel()[:count] if flat else found
