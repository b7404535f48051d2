"""The cache of compiled functions (kernels) next to their source files. It is cleared when any source file has changed.

Numba only checks the file that contains a function. However, the compiled function also contains all functions that it
calls, which may be in other files. Therefore one digest of all source files is kept in the `__pycache__` of the topmost
folder.
"""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path

NATIVE = Path(__file__).parent.parent
"""Folder of this simulator. Its packages contain all kernels."""


def forget_stale_kernels(folder: Path = NATIVE) -> None:
    """Remove compiled functions if any source file has changed since they were compiled.

    A read-only folder is not changed.

    Args:
        folder: Folder of the source files, including its subfolders.
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
    """Return a digest of the paths and contents of all source files."""
    digest = blake2b(digest_size=16)
    for source in sorted(folder.rglob("*.py")):
        digest.update(source.relative_to(folder).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()
