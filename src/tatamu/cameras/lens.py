"""Describes the lens of a camera by its focal length, centre and distortion, assumed or measured with a board.

The distortion is OpenCV's k1, k2, p1, p2, k3, for distances from the centre divided by the focal length.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import tomli_w
from pydantic import Field

from tatamu.base.errors import InputError
from tatamu.base.files import read_record, write_text
from tatamu.base.records import Record
from tatamu.cameras import opencv

USUAL = 0.85
"""Focal length of a usual phone, as a fraction of the picture's longer side."""

TURNS = {
    **{1: ((1, 0), (0, 1)), 2: ((-1, 0), (0, 1)), 3: ((-1, 0), (0, -1)), 4: ((1, 0), (0, -1))},
    **{5: ((0, 1), (1, 0)), 6: ((0, -1), (1, 0)), 7: ((0, -1), (-1, 0)), 8: ((0, 1), (-1, 0))},
}
"""Matrix by which each orientation tag turns and mirrors a picture about its middle."""


class Lens(Record):
    """The description of a camera's lens: focal length, centre and distortion."""

    width: int = Field(ge=16, le=100_000)
    """Width of the camera's pictures [pixels]."""
    height: int = Field(ge=16, le=100_000)
    focal: float = Field(gt=0.0, le=1e6)
    """Focal length of the lens [pixels]."""
    centre: tuple[float, float]
    """Position at which the optical axis meets the picture [pixels]."""
    distortion: Annotated[tuple[Annotated[float, Field(ge=-5.0, le=5.0)], ...], Field(max_length=5)] = ()


def load_lens(path: Path) -> Lens:
    """Read a lens from its file."""
    return read_record(Lens, "lens", path)


def write_lens(lens: Lens, path: Path) -> None:
    """Write a lens to a file."""
    write_text(path, tomli_w.dumps({"lens": lens.model_dump(mode="json")}))


def stated_focal(film: float | None, size: tuple[int, int]) -> float | None:
    """Convert a focal length `film`, which is stated for 35 mm film [mm], to pixels; None if `film` is None."""
    diagonal = 0.04327  # of 35 mm film [m]
    return None if film is None else 1e-3 * film / diagonal * float(np.hypot(*size))


def expected(size: tuple[int, int], lens: Lens | None, focal: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the expected lens of a photo with a stated focal length [pixels], and its deviations, shape (5,) each.

    The numbers are the logarithm of the focal length and the centre, both as fractions of the longer side, k1 and k2.
    """
    longer = max(size)
    if lens is not None:
        k1, k2 = (*lens.distortion, 0.0, 0.0)[:2]
        known = np.array([np.log(lens.focal / longer), lens.centre[0] / longer, lens.centre[1] / longer, k1, k2])
        return known, np.array([0.005, 0.001, 0.001, 1e-4, 1e-4])  # focusing changes the focal length
    usual, wide = (USUAL, 0.35) if focal is None else (focal / longer, 0.05)
    middle = np.array([np.log(usual), 0.5 * size[0] / longer, 0.5 * size[1] / longer, 0.0, 0.0])
    return middle, np.array([wide, 0.01, 0.01, 0.03, 0.01])  # phones correct most of the distortion


def turned(lens: Lens, orientation: int) -> Lens:
    """Return the lens for pictures that are turned as an orientation tag says, 1 to 8."""
    size = np.array([lens.width, lens.height])
    matrix = np.array(TURNS[orientation])
    new = np.abs(matrix) @ size
    centre = matrix @ (np.array(lens.centre) - 0.5 * (size - 1)) + 0.5 * (new - 1)
    bent = [*lens.distortion]
    if len(bent) > 3:  # p2 and p1 are the parts of a vector in the picture
        bent[3], bent[2] = (matrix @ [bent[3], bent[2]]).tolist()
    made = {"width": int(new[0]), "height": int(new[1]), "centre": tuple(centre.tolist()), "distortion": tuple(bent)}
    return lens.model_copy(update=made)


def possible_lenses(lens: Lens, size: tuple[int, int], orientation: int) -> list[Lens]:
    """Return the lenses that an upright photo may have been taken with; there are two if its file was turned untold.

    `lens` is that of the camera's sensor, and `orientation` the tag of the photo's file.

    Raises:
        InputError: If the ratio of the sides is different.
    """
    stored = size[::-1] if orientation >= 5 else size
    if (stored[0] > stored[1]) == (lens.width > lens.height):
        return [scaled(turned(lens, orientation), size)]
    if orientation >= 5:  # the file of the lens was made from upright photos
        return [scaled(lens, size)]
    return [scaled(turned(lens, quarter), size) for quarter in (6, 8)]


def scaled(lens: Lens, size: tuple[int, int]) -> Lens:
    """Return the lens for pictures of another width and height [pixels] in the same ratio."""
    factor = size[0] / lens.width
    if abs(size[1] / lens.height - factor) > 0.01 * factor:
        raise InputError(
            f"lens: must have the aspect ratio of the photo ({size[0]} x {size[1]} pixels), given {lens.width} x "
            f"{lens.height}; give the uncropped photo, or the lens file of this camera"
        )
    centre = tuple((factor * (np.array(lens.centre) + 0.5) - 0.5).tolist())
    return lens.model_copy(update={"width": size[0], "height": size[1], "focal": factor * lens.focal, "centre": centre})


def calibrate_lens(seen: Sequence[tuple[np.ndarray, np.ndarray]], size: tuple[int, int]) -> tuple[Lens, float]:
    """Find the lens from photos of one page of a board, and the root mean square error of the corners [pixels].

    Raises:
        InputError: If there are too few photos, or they are too similar.
    """
    if len(seen) < 4:
        raise InputError(f"photos: must be at least 4, given {len(seen)}; add photos from different sides and angles")
    cv2 = opencv()
    objects = [np.column_stack([places, np.zeros(len(places))]).astype(np.float32) for places, _ in seen]
    pixels = [found.astype(np.float32) for _, found in seen]
    start = np.array([[USUAL * max(size), 0, size[0] / 2], [0, USUAL * max(size), size[1] / 2], [0, 0, 1]])
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
    rms, matrix, distortion, turns, _ = cv2.calibrateCamera(objects, pixels, size, start, np.zeros(5), flags=flags)
    normals = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns])
    apart = float(np.degrees(np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0))))
    if apart < 20.0:
        raise InputError(
            f"photos: must show the board at angles that differ by at least 20 degrees, given {apart:.0f}; add photos "
            "from all sides with a tilted camera"
        )
    k1, k2 = (float(value) for value in distortion.ravel()[:2])
    centre = (float(matrix[0, 2]), float(matrix[1, 2]))
    lens = Lens(width=size[0], height=size[1], focal=float(matrix[0, 0]), centre=centre, distortion=(k1, k2))
    return lens, float(rms)
