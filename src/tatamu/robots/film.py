"""A film of a rehearsal: the robot, the table and the cloth, as an animated GIF."""

from __future__ import annotations

import io
import itertools
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.files import write_bytes
from tatamu.robots.extras import needed, one_line
from tatamu.robots.model import TABLE
from tatamu.robots.pose import frame_pose, into, out_of
from tatamu.robots.rehearsal import Rehearsal
from tatamu.robots.stage import Poser, link_shapes, load_stage
from tatamu.show.palette import BACK, FRONT
from tatamu.simulation.rollout import Rollout

RATE = 10
"""Frames per second."""
WIDTH, HEIGHT = 480, 360
"""Size of the pictures [pixels]."""
SIDES = {"tatamu_front": FRONT, "tatamu_back": BACK}
"""Names and colours of the two meshes for the front and the back of the cloth."""


def save_film(rehearsal: Rehearsal, fold: Rollout | None, path: Path) -> str | None:
    """Write the GIF, and return None. If this machine cannot draw, return the reason instead.

    MuJoCo draws with OpenGL. The environment variable MUJOCO_GL selects the variant of OpenGL.
    """
    image = needed("PIL.Image")
    try:
        frames = [image.fromarray(pixels).quantize(64) for pixels in _frames(rehearsal, fold)]
    except Exception as error:  # the error depends on how OpenGL is missing or broken
        return one_line(error)
    buffer = io.BytesIO()
    frames[0].save(buffer, "GIF", save_all=True, append_images=frames[1:], duration=1000 // RATE, loop=0)
    write_bytes(path, buffer.getvalue())
    return None


def _frames(rehearsal: Rehearsal, fold: Rollout | None) -> list[np.ndarray]:
    mujoco = needed("mujoco")
    planned = rehearsal.planned
    spec = load_stage(planned.folder)
    _dressed(spec, rehearsal, fold, mujoco)
    model = spec.compile()
    times = np.arange(0, rehearsal.times[-1], 1 / RATE)
    rows = np.searchsorted(rehearsal.times, times)
    poser = Poser(model, planned, rehearsal.angles[rows], times)
    camera = _camera(model, poser, rehearsal, mujoco)
    found = []
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        for number, time in enumerate(times):
            data = poser.pose(number)
            mujoco.mj_camlight(model, data)
            if fold is not None:
                frame = int(np.clip(np.searchsorted(fold.times, time - rehearsal.closes), 0, len(fold.times) - 1))
                _lay(model, data, renderer, rehearsal, fold.positions[frame], mujoco)
            renderer.update_scene(data, camera)
            found.append(renderer.render().copy())
    return found


def _camera(model: Any, poser: Poser, rehearsal: Rehearsal, mujoco: Any) -> Any:
    """Return the nearest camera that shows the robot and the table during the whole film."""
    shown = [k for k in link_shapes(model) if model.geom(k).name not in SIDES]
    poses = np.linspace(0, poser.poses - 1, 12).astype(int)  # the camera must show the robot completely in these
    links = np.concatenate([poser.pose(int(row)).geom_xpos[shown] for row in poses])
    table = model.geom(TABLE)
    corners = table.pos + table.size * np.array(list(itertools.product((-1, 1), repeat=3)))
    points = np.concatenate([links, corners])
    around = np.concatenate([np.tile(model.geom_rbound[shown], len(poses)), np.zeros(len(corners))])
    camera = mujoco.MjvCamera()
    # The arms are assumed to face each other if the robot is much wider than deep, seen from above.
    apart = np.ptp(links[:, 1]) > 1.4 * np.ptp(np.append(links[:, 0], corners[:, 0]))
    camera.azimuth, camera.elevation = (190.0 if apart else 215.0), -28.0
    direction = camera.azimuth, camera.elevation
    camera.lookat[:], camera.distance = framed(points, around, direction, model.vis.global_.fovy)
    return camera


def framed(
    points: np.ndarray, around: np.ndarray, direction: tuple[float, float], view: float
) -> tuple[np.ndarray, float]:
    """Find the nearest camera whose picture shows all given spheres.

    Return the point that the camera looks at, and the camera's distance from this point [m].

    Args:
        points: Centres of the spheres [m], shape (n, 3).
        around: Radii of the spheres [m], shape (n,).
        direction: Direction in which the camera looks: its angle about z from the x axis, and its angle above the
            horizontal [degrees].
        view: Angle of the picture's height [degrees].
    """
    a, e = np.radians(direction)
    ahead = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([np.sin(a), -np.cos(a), 0.0])
    axes = np.array([right, np.cross(right, ahead), ahead])
    seen = points @ axes.T
    middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
    high = np.tan(np.radians(view) / 2)
    wide = high * WIDTH / HEIGHT
    across, up = (np.abs(seen - middle) + around[:, None]).T[:2]
    depth = (seen - middle)[:, 2]
    return middle @ axes, float(max((across / wide - depth).max(), (up / high - depth).max()))


def _dressed(spec: Any, rehearsal: Rehearsal, fold: Rollout | None, mujoco: Any) -> None:
    """Add a light and the cloth to the robot's model, and cut the table to a size that fits the picture."""
    spec.worldbody.add_light(pos=[0.5, 0.5, 2.0], dir=[0, -0.2, -1], castshadow=False)
    spec.visual.headlight.ambient = [0.4, 0.4, 0.4]
    sky, plain = mujoco.mjtTexture.mjTEXTURE_SKYBOX, mujoco.mjtBuiltin.mjBUILTIN_FLAT
    grey = [0.96, 0.96, 0.94]
    spec.add_texture(name="tatamu_sky", type=sky, builtin=plain, rgb1=grey, rgb2=grey, width=16, height=96)
    table, middle = spec.geom(TABLE), rehearsal.tools.mean(axis=(0, 1))
    reach = np.abs(rehearsal.tools - middle).max(axis=(0, 1)) + 0.12  # from the paths of the tools to the edge [m]
    table.size = [reach[0], reach[1], table.size[2]]
    table.pos = [middle[0], middle[1], table.pos[2]]
    if fold is not None:
        vertices = _in_base(rehearsal, fold.positions[0])
        kind, shell = mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        for (side, colour), faces in zip(SIDES.items(), (fold.faces, fold.faces[:, ::-1]), strict=True):
            spec.add_mesh(name=side, uservert=vertices.ravel(), userface=faces.ravel(), inertia=shell)
            rgba = [int(colour[k : k + 2], 16) / 340 for k in (1, 3, 5)] + [1]  # darkened, because the light is bright
            spec.worldbody.add_geom(name=side, type=kind, meshname=side, contype=0, conaffinity=0, rgba=rgba)


def _in_base(rehearsal: Rehearsal, positions: np.ndarray) -> np.ndarray:
    return out_of(rehearsal.planned.plan.task_in_base.matrix, positions) + np.array([0, 0, 0.002])


def _lay(model: Any, data: Any, renderer: Any, rehearsal: Rehearsal, positions: np.ndarray, mujoco: Any) -> None:
    """Move the vertices of the cloth's mesh to the given positions."""
    in_base = _in_base(rehearsal, positions)
    for side in SIDES:
        geom = data.geom(side)
        vertices = into(frame_pose(geom), in_base)
        start = int(model.mesh(side).vertadr[0])
        model.mesh_vert[start : start + len(vertices)] = vertices
        mujoco.mjr_uploadMesh(model, renderer._mjr_context, model.mesh(side).id)
