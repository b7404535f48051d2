"""Draws a picture of a learned fold without a browser: the folded cloth, the cloth in motion, and the hands' paths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tatamu.report.topview import painted
from tatamu.show.image import save_png
from tatamu.show.palette import LEFT, RIGHT, SOLID, TABLE, rgb
from tatamu.show.raster import View
from tatamu.show.shading import SUN, PaintedMesh, cloth, see, shade, shrink, to_pixels
from tatamu.show.solids import moving, tube
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.study.result import Result

SIZE = (720, 1280)
"""Height and width of the picture [pixels]."""
FINER = 2
"""Factor by which the picture is first drawn larger. Then it is reduced by averaging, which makes edges smooth."""
SHADOW = 1200
"""Height and width of an image of the scene as seen from the sun [pixels]. This image determines the shadows."""


def picture(folder: Path, out_png: Path) -> Path:
    """Draw the learned fold of a result folder, and write the picture to a PNG file.

    Raises:
        InputError: If the folder contains no learned fold, or the file cannot be written.
    """
    fold = Result.load(Path(folder))
    save_png(to_pixels(shrink(render(fold), FINER)), Path(out_png))
    return Path(out_png)


def render(fold: Result, hands: tuple[str, ...] = (LEFT, RIGHT), *, flying: bool = True) -> np.ndarray:
    """Return the picture of a fold in linear light, shape (h, w, 4). It is `FINER` times larger than its final size.

    Args:
        fold: The fold to draw.
        hands: Colours of the hands' paths; a hand without a colour is not drawn.
        flying: Whether to draw the cloth twice: after the fold, and at the moment when a hand is highest.
    """
    paths = [fold.hand(arm) for arm in fold.arms]
    body = painted(fold, fold.final)
    flight = painted(fold, fold.rollout.positions[np.argmax(paths[0][:, 2])])
    view = _eye(np.vstack([fold.final, flight.points, *paths]))
    lowest = float(fold.start[:, 2].min()) - fold.scene.material.thickness / 2
    painting = _Painting(view, _Sun([body], np.vstack([fold.final, *paths])), lowest)
    for mesh in [body, *_solids(fold.scene, fold.rollout.times[-1])]:
        painting.add(mesh)
    for colour, path in zip(hands, paths, strict=False):
        painting.add(_plain(*tube(path, 0.0035), colour), sunny=False)
    if flying:
        painting.add(flight, sunny=False, alpha=0.42)
    return painting.image


def scene_picture(scene: Scene, rollout: Rollout, frame: int) -> np.ndarray:
    """Return a picture of a scene's cloth and rigid bodies in one frame, as uint8 of shape (h, w, 4)."""
    body = cloth(rollout.positions[frame], rollout.faces, scene.cloth.rest)
    meshes = [body, *_solids(scene, rollout.times[frame])]
    around = np.vstack([mesh.points for mesh in meshes])
    height = scene.table.height if scene.table else float(around[:, 2].min())
    painting = _Painting(_eye(around), _Sun(meshes, around), height)
    for mesh in meshes:
        painting.add(mesh)
    return to_pixels(shrink(painting.image, FINER))


def _solids(scene: Scene, time: float) -> list[PaintedMesh]:
    """Return the rigid bodies of a scene at a time [s], as a list with one mesh; empty if the scene has no bodies."""
    mesh = moving(scene.bodies, np.array([time]))
    return [] if mesh is None else [_plain(mesh[0][0], mesh[1], SOLID)]


def _plain(points: np.ndarray, faces: np.ndarray, colour: str) -> PaintedMesh:
    """Return a mesh of one colour."""
    light = rgb(colour)
    return PaintedMesh(points, faces, np.tile(light, (len(faces), 1)), light)


def _eye(points: np.ndarray) -> View:
    """Return a view from the front and obliquely from above, in which all points (n, 3) are visible."""
    turn = np.radians(-62.0)
    rise = np.radians(33.0)
    near = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    right = np.cross([0.0, 0.0, 1.0], near) / np.cos(rise)
    rotation = np.vstack([right, np.cross(near, right), near])
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    shape = (SIZE[0] * FINER, SIZE[1] * FINER)
    distance = 3.2 * float(np.linalg.norm(points - centre, axis=1).max())
    flat = View(centre, rotation, 1.0, (0, 0), distance).project(points)[:, :2]
    middle = rotation[:2].T @ ((flat.min(axis=0) + flat.max(axis=0)) / 2 * [1, -1])
    scale = float((0.86 * np.array(shape[::-1]) / np.ptp(flat, axis=0)).min())
    return View(centre + middle, rotation, scale, shape, distance)


class _Sun:
    """The scene as seen from the sun. A point that is hidden from the sun is in shadow."""

    def __init__(self, meshes: list[PaintedMesh], around: np.ndarray) -> None:
        right = np.cross([0.0, 1.0, 0.0], SUN) / np.linalg.norm(np.cross([0.0, 1.0, 0.0], SUN))
        rotation = np.vstack([right, np.cross(SUN, right), SUN])
        centre = around.mean(axis=0)
        reach = 1.1 * float(np.linalg.norm(around - centre, axis=1).max())
        self.view = View(centre, rotation, SHADOW / (2 * reach), (SHADOW, SHADOW))
        self.depth = np.max([see(self.view, mesh)[1] for mesh in meshes], axis=0)

    def reaches(self, points: np.ndarray) -> np.ndarray:
        """Return the light at each of p points, from 0 (in shadow) to 1 (in full light), shape (p,).

        The light is averaged over neighbouring pixels, which gives soft edges of shadows.
        """
        x, y, depth = self.view.project(points).T
        total = np.zeros(len(points))
        for dx, dy in (offsets := [(i, j) for i in (-5, -2, 0, 2, 5) for j in (-5, -2, 0, 2, 5)]):
            column = np.clip((x + dx).astype(int), 0, SHADOW - 1)
            row = np.clip((y + dy).astype(int), 0, SHADOW - 1)
            total += self.depth[row, column] < depth + 0.003
        return total / len(offsets)


class _Painting:
    """A picture of a table, to which meshes are added."""

    def __init__(self, view: View, sun: _Sun, height: float) -> None:
        """Begin with the table at a height [m]."""
        self._view, self._sun = view, sun
        self.image = _table(view, sun, height)
        self._depth = np.full(view.shape, -np.inf)

    def add(self, mesh: PaintedMesh, *, sunny: bool = True, alpha: float = 1.0) -> None:
        """Draw a mesh at those pixels where it is nearer than everything before, without shadows if not `sunny`."""
        visible, near = see(self._view, mesh)
        lit = 0.25 + 0.75 * self._sun.reaches(visible.sample(mesh.points, mesh.faces)) if sunny else 1.0
        light = np.zeros((*self._view.shape, 3))
        light[visible.mask] = shade(self._view, mesh, visible, lit)
        nearer = near > self._depth
        self.image[nearer, :3] = alpha * light[nearer] + (1 - alpha) * self.image[nearer, :3]
        if alpha == 1.0:
            self._depth[nearer] = near[nearer]


def _table(view: View, sun: _Sun, height: float) -> np.ndarray:
    """Return an image of the table with the cloth's shadow, shape (h, w, 4). Far away, the table fades to white."""
    view = replace(view, scale=view.scale / FINER, shape=SIZE)  # fewer pixels, because the light is soft
    rows, columns = view.shape
    y, x = np.mgrid[0:rows, 0:columns] + 0.5
    across = np.stack([(x - columns / 2) / view.scale, (rows / 2 - y) / view.scale], axis=-1)
    eye = view.centre + view.distance * view.rotation[2]
    ray = across @ view.rotation[:2] - view.distance * view.rotation[2]
    points = eye + ray * ((height - eye[2]) / np.minimum(ray[..., 2:], -1e-9))
    lit = sun.reaches(points.reshape(-1, 3)).reshape(rows, columns)
    away = np.linalg.norm(points[..., :2] - view.centre[:2], axis=-1) * view.scale / columns
    fade = np.clip(1.5 * away - 0.2, 0.0, 1.0)[..., None] ** 1.5
    light = rgb(TABLE) * (0.62 + 0.38 * lit[..., None]) * (1 - fade) + fade
    image = np.concatenate([light, np.ones((rows, columns, 1))], axis=-1)
    return image.repeat(FINER, axis=0).repeat(FINER, axis=1)
