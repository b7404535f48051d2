"""The source on which a rollout depends, so that what was simulated by another version is simulated again."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

import tatamu

PARTS = ("simulators", "scene.py", "material.py", "topology.py", "crossings.py")
"""Parts of the package on which a rollout depends."""


@cache
def source_digest() -> str:
    """A digest of the source that decides a rollout; hexadecimal."""
    root = Path(tatamu.__file__).parent
    files = [
        path for part in PARTS for path in ([root / part] if part.endswith(".py") else (root / part).rglob("*.py"))
    ]
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()
