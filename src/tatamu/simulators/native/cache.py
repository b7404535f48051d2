"""Compiled kernels are kept on disk beside their sources; this forgets them when any source has changed.

Numba looks only at the file of the function itself, but a kernel contains everything that it calls, from whatever file.
"""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path

FOLDER = Path(__file__).parent


def forget_stale_kernels() -> None:
    """Remove compiled kernels that were made from other sources than these; a read-only folder is left alone."""
    digest = blake2b(digest_size=16)
    for source in sorted(FOLDER.glob("*.py")):
        digest.update(source.read_bytes())
    kept, stamp = FOLDER / "__pycache__", digest.hexdigest()
    mark = kept / "kernels.txt"
    try:
        if mark.exists() and mark.read_text() == stamp:
            return
        for kernel in [*kept.glob("*.nbi"), *kept.glob("*.nbc")]:
            kernel.unlink(missing_ok=True)
        kept.mkdir(exist_ok=True)
        mark.write_text(stamp)
    except OSError:
        return
