"""Blender as a separate process, because it is licensed under the GPL and has global state.

It receives recipes and returns positions through pipes, starts when it is first needed, restarts after a crash, and
ends when its standard input closes, which also happens if tatamu is killed.
"""

from __future__ import annotations

import atexit
import json
import os
import struct
import subprocess
import tempfile
import threading
from contextlib import suppress
from typing import IO, Any

import numpy as np

from tatamu.base.errors import InputError, SimulationError
from tatamu.simulation.blender import discovery

MARK = b"\x00\xfftatamu\xff\x00"
"""Start of every message. All bytes between two messages are output of Blender itself."""
ATTEMPTS = 3
"""Number of attempts to run a recipe, after which the recipe counts as the cause of the crashes."""


class WorkerDied(Exception):
    """The pipe from Blender ended before the answer came."""


class Worker:
    """One Blender process and its pipes."""

    def __init__(self) -> None:
        self.owner = os.getpid()
        self.command = discovery.command()
        self.log: IO[bytes] = tempfile.TemporaryFile()
        self.scratch = tempfile.TemporaryDirectory(prefix="tatamu-blender-", ignore_cleanup_errors=True)
        environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONHOME")}
        # If Blender is killed, it leaves its temporary files behind. They are then deleted with this folder.
        environment |= dict.fromkeys(("TMPDIR", "TEMP", "TMP"), self.scratch.name)
        try:
            self.process = subprocess.Popen(
                self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log, env=environment
            )
        except OSError as error:
            self.scratch.cleanup()
            raise InputError(f"{self.command[0]}: cannot be started ({error.strerror or error})") from None
        self.version = self._greeting()

    def _greeting(self) -> str:
        limit = threading.Timer(120.0, self.process.kill)  # how long the first message may take [s]
        limit.start()
        try:
            return str(self._receive()[0]["blender"])
        except WorkerDied:
            self.log.seek(0)
            lines = self.log.read()[-2000:].decode(errors="replace").strip().splitlines()
            words = f" ({lines[-1].strip()})" if lines else ""
            self.close()
            raise InputError(f"{self.command[0]}: cannot be run as Blender{words}") from None
        finally:
            limit.cancel()

    def ask(self, request: dict[str, Any]) -> tuple[dict[str, Any], np.ndarray]:
        """Run one recipe, and return the answer and the positions (float32), or raise WorkerDied."""
        assert self.process.stdin is not None
        text = json.dumps(request, allow_nan=False).encode()
        try:
            self.process.stdin.write(MARK + struct.pack("<I", len(text)) + text)
            self.process.stdin.flush()
        except OSError:
            raise WorkerDied from None
        return self._receive()

    def _receive(self) -> tuple[dict[str, Any], np.ndarray]:
        window = self._exactly(len(MARK))
        while window != MARK:
            window = window[1:] + self._exactly(1)
        answer = json.loads(self._exactly(struct.unpack("<I", self._exactly(4))[0]))
        return answer, np.frombuffer(self._exactly(answer.get("bytes", 0)), dtype="<f4")

    def _exactly(self, count: int) -> bytes:
        assert self.process.stdout is not None
        data = self.process.stdout.read(count)
        if len(data) < count:
            raise WorkerDied
        return data

    def close(self) -> None:
        """End the process, and wait until it has ended, so that no zombie process remains."""
        for pipe in (self.process.stdin, self.process.stdout, self.log):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        if os.getpid() == self.owner:
            self.process.kill()
            self.process.wait()
            self.scratch.cleanup()


class Workers:
    """The idle Blender processes that this process has started. Only one thread at a time uses a worker."""

    def __init__(self) -> None:
        self._idle: list[Worker] = []
        self._lock = threading.Lock()

    def run(self, request: dict[str, Any]) -> tuple[dict[str, Any], np.ndarray, str]:
        """Run one recipe, again if Blender crashes, and return the answer, the positions and Blender's version."""
        for _ in range(ATTEMPTS):
            with self._lock:
                mine = [worker for worker in self._idle if worker.owner == os.getpid()]
                self._idle = mine[:-1]
            worker = mine[-1] if mine else Worker()
            try:
                answer, positions = worker.ask(request)
            except WorkerDied:
                worker.close()
                continue
            except BaseException:
                worker.close()
                raise
            with self._lock:
                self._idle.append(worker)
            if "error" in answer:
                raise SimulationError(f"blender: {answer['error']}")
            return answer, positions, worker.version
        raise SimulationError(f"blender: crashed {ATTEMPTS} times on this scene")

    def close(self) -> None:
        with self._lock:
            idle, self._idle = self._idle, []
        for worker in idle:
            worker.close()


WORKERS = Workers()
atexit.register(WORKERS.close)
