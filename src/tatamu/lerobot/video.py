"""Videos in AV1, as LeRobot stores them: encoder libsvtav1, pixel format yuv420p, every second frame a key frame."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.extras import needed
from tatamu.base.files import foreign, writing

CODEC = "libsvtav1"
OPTIONS = {"g": "2", "crf": "30", "preset": "12", "svtav1-params": "fast-decode=0:lp=1"}
"""LeRobot's options, and one thread (lp), so that every machine writes the same bytes."""


def check_codec() -> None:
    """Refuse to go on if videos cannot be encoded.

    Raises:
        InputError: If PyAV is not installed, or has no encoder for AV1.
    """
    av = needed("av", "dataset")
    os.environ.setdefault("SVT_LOG", "0")  # otherwise the encoder writes its version to standard error
    try:
        av.codec.Codec(CODEC, "w")
    except (ValueError, av.FFmpegError):
        raise InputError(
            f"cameras: videos need the encoder {CODEC}, which the installed PyAV lacks; run "
            "`pip install 'tatamu[dataset]'`, or write cameras = []"
        ) from None


class VideoWriter:
    """A video to which pictures are appended.

    Attributes:
        frames: Number of pictures.
        size: Size of the encoded pictures, without the last ones [bytes].
    """

    def __init__(self, path: Path, fps: int, height: int, width: int) -> None:
        """Create the file of the video.

        Raises:
            InputError: If the file cannot be written, or there is no encoder.
        """
        check_codec()
        av = needed("av", "dataset")
        av.logging.set_level(av.logging.PANIC)
        self.frames = 0
        self.size = 0
        self._path = path
        self._fps = fps
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("w+b")
        self._container = av.open(self._file, "w", format="mp4")
        self._stream: Any = self._container.add_stream(CODEC, rate=fps, options=OPTIONS)
        self._stream.width, self._stream.height, self._stream.pix_fmt = width, height, "yuv420p"
        self._stream.time_base = self._stream.codec_context.time_base = Fraction(1, fps)
        with _unchanged_priority():
            self._stream.codec_context.open()
        self._av = av

    def add(self, values: np.ndarray) -> Mapping[str, float]:
        """Append pictures, RGB, uint8, shape (f, h, w, 3), and return when they start and end [s]."""
        first = self.frames
        with writing(self._path):
            for picture in values:
                frame = self._av.VideoFrame.from_ndarray(picture, format="rgb24")
                frame.pts = self.frames
                packets = self._stream.encode(frame)
                self._container.mux(packets)
                self.size += sum(packet.size for packet in packets)
                self.frames += 1
        return {"from_timestamp": first / self._fps, "to_timestamp": self.frames / self._fps}

    def close(self) -> None:
        """Write the remaining pictures, and close the file."""
        with writing(self._path), self._file, self._container:
            self._container.mux(self._stream.encode())


@contextmanager
def _unchanged_priority() -> Iterator[None]:
    """Keep the scheduling policy of this process.

    If root runs the encoder, it makes its threads and the calling one real-time threads (SCHED_FIFO), which would take
    the processors from all other programs.
    """
    if not hasattr(os, "sched_getscheduler"):
        yield
        return
    policy, parameter = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        yield
    finally:
        if os.sched_getscheduler(0) != policy:
            for thread in Path("/proc/self/task").iterdir():
                with suppress(ProcessLookupError):  # the thread has ended
                    os.sched_setscheduler(int(thread.name), policy, parameter)


def read_video(path: Path) -> Iterator[np.ndarray]:
    """Yield the pictures of a video: RGB, uint8, shape (h, w, 3)."""
    av = needed("av", "dataset")
    with foreign(path, "a video"), av.open(str(path)) as container:
        for frame in container.decode(video=0):
            yield frame.to_ndarray(format="rgb24")
