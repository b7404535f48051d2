"""The cache of compiled kernels next to their source files, which is cleared when any source file has changed.

Numba only checks the file of a function, but compiled code also contains functions of other files that it calls. The
topmost `__pycache__` therefore has a digest of all source files.
"""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path

NATIVE = Path(__file__).parent.parent
"""Folder of all kernels."""


def forget_stale_kernels(folder: Path = NATIVE) -> None:
    """Remove compiled functions if a source file in a folder has changed since; leave a read-only folder as it is."""
    stamp = _stamp(folder)
    mark = folder / "__pycache__" / "kernels.txt"
    try:
        if mark.exists() and mark.read_text() == stamp:
            return
        for cache in folder.rglob("__pycache__"):
            for kernel in [*cache.glob("*.nbi"), *cache.glob("*.nbc")]:
                kernel.unlink(missing_ok=True)
        mark.parent.mkdir(exist_ok=True)
        mark.write_text(stamp)
    except OSError:
        return


def _stamp(folder: Path) -> str:
    """Return a digest of the paths and contents of all source files."""
    digest = blake2b(digest_size=16)
    for source in sorted(folder.rglob("*.py")):
        digest.update(source.relative_to(folder).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()
