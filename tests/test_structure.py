"""The shape of the package: imports point one way, exports are what they say."""

from __future__ import annotations

import ast
from pathlib import Path

import tatamu

SOURCE = Path(tatamu.__file__).parent
ORDER = [
    ["errors"],
    ["files", "records", "curves", "size"],
    ["topology", "heavy_strip", "plate_in_air", "zbuffer", "meshing"],
    ["material"],
    ["settling"],
    ["presets"],
    ["scene", "rollout", "crossings"],
    ["subdivision"],
    ["presentation"],
    ["instruments"],
    ["simulators"],
    ["cluster"],
    ["search"],
    ["options"],
    ["garments"],
    ["calibration"],
    ["folding"],
    ["disturbances"],
    ["evaluation"],
    ["robustness"],
    ["study"],
    ["report"],
    ["crosscheck", "margins"],
    ["validation"],
    ["robots"],
    ["sweep"],
    ["reproduction"],
    ["api"],
    ["cli"],
]
"""Each part may import itself and what stands above it."""


def _part(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


def _imports(file: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("tatamu"):
            names |= {_part(node.module)} if node.module != "tatamu" else {a.name for a in node.names}
        elif isinstance(node, ast.Import):
            names |= {_part(a.name) for a in node.names if a.name.startswith("tatamu.")}
    return names - {"", "__version__"}


def test_imports_point_one_way() -> None:
    rank = {part: number for number, parts in enumerate(ORDER) for part in parts}
    for file in SOURCE.rglob("*.py"):
        own = file.relative_to(SOURCE).parts[0].removesuffix(".py")
        if own == "__init__":
            continue
        for imported in _imports(file):
            assert imported == own or rank[imported] < rank[own], f"{file.name} of {own} imports {imported}"


def test_every_public_name_can_be_imported_and_is_listed() -> None:
    assert tatamu.__all__ == sorted(tatamu.__all__)
    assert set(tatamu.__all__) == set(tatamu._HOME)
    for name in tatamu.__all__:
        assert getattr(tatamu, name).__module__.startswith("tatamu.")
