"""The cache of compiled kernels next to their sources, which is cleared when any source has changed.

Numba checks only the file of the function itself, but a kernel contains everything that it calls, from other files as
well. One stamp for all of them is therefore kept in the `__pycache__` of the topmost folder.
"""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path

NATIVE = Path(__file__).parent.parent
"""The folder of the embedded simulator, whose packages all have kernels."""


def forget_stale_kernels(folder: Path = NATIVE) -> None:
    """Remove compiled kernels that were made from other sources than these; a read-only folder is left alone.

    Args:
        folder: Where the sources lie, in it and in folders within it.
    """
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
    """Return a digest of all sources with their paths."""
    digest = blake2b(digest_size=16)
    for source in sorted(folder.rglob("*.py")):
        digest.update(source.relative_to(folder).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()
