"""Reads pictures of any depth, and turns them upright as their orientation tag says."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.extras import require
from tatamu.base.files import MIB, foreign, in_shell, read_bytes

MAX_PICTURE = 256 * MIB
"""Largest size of a picture's file [bytes]."""


@dataclass(frozen=True)
class Picture:
    """The contents of a picture file, turned upright."""

    pixels: np.ndarray
    """8-bit RGB, shape (h, w, 3)."""
    alpha: np.ndarray | None
    """Alpha channel, shape (h, w), if it cuts something out."""
    film: float | None
    """Focal length with the same field of view on 35 mm film [mm], if the file states it."""
    orientation: int
    """Orientation tag of the file, 1 to 8: how the sensor's pixels were turned to make them upright."""

    @property
    def sensor(self) -> np.ndarray:
        """Pixels in the orientation of the camera's sensor, shape (h, w, 3) or (w, h, 3)."""
        back = {6: 8, 8: 6}.get(self.orientation, self.orientation)  # each of the others undoes itself
        return np.ascontiguousarray(turned(self.pixels, back))


def turned(pixels: np.ndarray, orientation: int) -> np.ndarray:
    """Return an array (h, w, ..) that is turned and mirrored as an orientation tag says."""
    if orientation >= 5:
        pixels = pixels.swapaxes(0, 1)
    return pixels[:: -1 if orientation in (3, 4, 7, 8) else 1, :: -1 if orientation in (2, 3, 6, 7) else 1]


def read_picture(path: Path) -> Picture:
    """Read a picture and turn it upright.

    Raises:
        InputError: If the file cannot be read, is not a picture, or is too large.
    """
    from PIL import ExifTags

    data = read_bytes(path, MAX_PICTURE)
    with foreign(path, "a picture that tatamu can read"):
        file = _opened(data, path)
        tags: Any = _tiff_tags(data) if file is None else getattr(file, "tag_v2", {})
        size: tuple[int, int] = file.size if file is not None else (int(tags[256]), int(tags[257]))
        if size[0] * size[1] > 100_000_000 or max(size) > 50 * min(size):
            limits = "at most 100 million pixels, and sides with a ratio of at most 50"
            raise InputError(f"{path}: photo: must have {limits}, given {size[0]} x {size[1]}")
        if file is None:
            return _picture(*_parts(_decoded(data, tags), tags), None, 1)
        with file:
            # Pillow would keep the upper 8 bits of deeper colours; this is before tags are read, which loads a PNG file
            if file.format == "TIFF":
                _check_pages(file, path)
                deep = max(tags.get(258, (1,))) > 8  # BitsPerSample
            else:
                deep = file.mode.startswith("I") or any(";16" in str(tile[3]) for tile in file.tile)
            stated = file.getexif()
            tag = stated.get(ExifTags.Base.Orientation)
            orientation = int(tag) if tag in range(1, 9) else 1
            if deep:
                _opened(data, path).verify()  # libpng would complain of wrong checksums on the console
                pixels, alpha = _parts(_decoded(data, tags), tags)
            else:
                alpha = np.asarray(file.convert("RGBA"))[..., 3] if file.has_transparency_data else None
                pixels = np.asarray(file.convert("RGB"))
            if file.format != "TIFF":  # both decoders have turned those already
                pixels, alpha = turned(pixels, orientation), None if alpha is None else turned(alpha, orientation)
            # of equivalent 35 mm film, if it is plausible
            film = stated.get_ifd(ExifTags.IFD.Exif).get(ExifTags.Base.FocalLengthIn35mmFilm)
            film = float(film) if isinstance(film, int) and 8 <= film <= 300 else None
            return _picture(pixels, alpha, film, orientation)


def _picture(pixels: np.ndarray, alpha: np.ndarray | None, film: float | None, orientation: int) -> Picture:
    # an alpha channel that keeps more only rounds the picture's corners
    cuts_out = alpha is not None and (alpha > 127).mean() < 0.97
    return Picture(np.ascontiguousarray(pixels), alpha if cuts_out else None, film, orientation)


def _opened(data: bytes, path: Path) -> Any:
    """Return the open picture; None for a TIFF file that Pillow does not know."""
    from PIL import Image, UnidentifiedImageError

    try:
        return Image.open(io.BytesIO(data), formats=("JPEG", "PNG", "WEBP", "BMP", "TIFF", "GIF"))
    except UnidentifiedImageError:
        if data[:4] in (b"II*\0", b"MM\0*"):
            return None
        phone = data[4:8] == b"ftyp" or path.suffix.lower() in (".heic", ".heif", ".avif")
        command = f"heif-convert {in_shell(path)} {in_shell(path.with_suffix('.png'))}"
        hint = f"; convert the file to JPEG or PNG, for example with `{command}`" if phone else ""
        raise InputError(
            f"{path}: must be a picture in JPEG, PNG, WEBP, BMP, TIFF or GIF, given another format{hint}"
        ) from None


def _check_pages(file: Any, path: Path) -> None:
    """Refuse a TIFF file whose first picture is a preview, or one of several that are as large."""
    from PIL import ImageSequence

    preview = file.tag_v2.get(254, 0) & 1  # NewSubfileType
    first, *others = (math.prod(page.size) for _, page in zip(range(100), ImageSequence.Iterator(file), strict=False))
    if preview or len(others) == 99 or max(others, default=0) >= first:
        given = "given several or a camera's raw data; save the photo as JPEG or PNG"
        raise InputError(f"{path}: photo: must be a single picture, {given}")
    file.seek(0)


def _tiff_tags(data: bytes) -> Any:
    from PIL.TiffImagePlugin import ImageFileDirectory_v2

    stream = io.BytesIO(data)
    tags = ImageFileDirectory_v2(stream.read(8))
    stream.seek(tags.next)
    tags.load(stream)
    return tags


def _decoded(data: bytes, tags: Any) -> np.ndarray:
    """Return a picture with more than 8 bits as red, green, blue, shape (h, w, channels)."""
    require("cv2", "photo", "photos with more than 8 bits for each colour", "opencv-python-headless")
    import cv2

    log: Any = cv2.utils.logging
    before = log.setLogLevel(log.LOG_LEVEL_SILENT)  # libtiff would complain of broken tags on the console
    try:
        found: Any = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    finally:
        log.setLogLevel(before)
    planes_apart = tags.get(284, 1) == 2 and tags.get(277, 1) > 1  # of which OpenCV leaves pixels undefined
    if found is None or planes_apart:
        raise ValueError("the pixel format is not supported; save the picture as an 8-bit PNG in grey or RGB")
    found = found.reshape(*found.shape[:2], -1)
    return found[..., [2, 1, 0, *range(3, found.shape[2])]] if found.shape[2] >= 3 else found


def _parts(values: np.ndarray, tags: Any) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the colours and the alpha channel, if there is one, in 8 bits."""
    count = values.shape[2]
    colours = _eight_bits(values[..., : 3 if count >= 3 else 1])
    cuts_out = count in (2, 4) and 0 not in np.atleast_1d(tags.get(338, 1))  # ExtraSamples, 0 if it is anything
    alpha = _eight_bits(values[..., -1]) if cuts_out else None
    return np.repeat(colours, 3 // colours.shape[2], axis=2), alpha


def _eight_bits(values: np.ndarray) -> np.ndarray:
    """Return numbers of any range in 8 bits: white is the largest value of the smallest usual depth that holds them."""
    if values.dtype == np.uint8:
        return values
    some = values.ravel()[:: max(1, values.size // 1_000_000)]
    low, top = (float(value) for value in np.percentile(some, (0.1, 99.9)))  # single pixels may be defective
    if not (np.isfinite(values).all() and low >= -0.05 * top):
        raise ValueError("pixels must be finite and at least 0")
    whites = [float(2**depth - 1) for depth in (8, 10, 12, 14, 16)]
    if values.dtype.kind == "f" and top <= 16.0:  # their white is 1
        whites = [1.0, top]
    white = next((white for white in whites if top <= white), top)
    return np.clip(np.round(values * (255.0 / white)), 0, 255).astype(np.uint8)
