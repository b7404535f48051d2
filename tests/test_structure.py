"""The shape of the package: imports point one way, exports are what they say."""

from __future__ import annotations

import ast
from pathlib import Path

import tatamu

SOURCE = Path(tatamu.__file__).parent
ORDER = [
    "base",
    "simulation",
    "show",
    "lerobot",
    "cluster",
    "search",
    "garments",
    "calibration",
    "folding",
    "evaluation",
    "study",
    "cameras",
    "report",
    "after",
    "robots",
    "sweep",
    "policies",
    "envs",
    "api",
    "cli",
]
"""Rooms of the package. Each may import itself and the rooms before it."""
CIRCLES: list[set[str]] = []
"""Circles of modules that are still there. The list may only become shorter."""


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
    rank = {room: place for place, room in enumerate(ORDER)}
    for file in SOURCE.rglob("*.py"):
        own = file.relative_to(SOURCE).parts[0].removesuffix(".py")
        if own in ("__init__", "__main__"):
            continue
        for imported in _imports(file):
            assert imported == own or rank[imported] < rank[own], f"{file.name} of {own} imports {imported}"


def _modules(root: Path) -> dict[str, Path]:
    """Name of each module of a package, and its file."""
    paths = {".".join(file.relative_to(root.parent).with_suffix("").parts): file for file in root.rglob("*.py")}
    return {name.removesuffix(".__init__"): file for name, file in paths.items()}


def _imported(modules: dict[str, Path]) -> dict[str, set[str]]:
    """Module to the modules that it imports anywhere: at its head, inside functions, and for type checking alone."""
    found = {}
    for name, file in modules.items():
        names: set[str] = set()
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{name}: a relative import escapes this test"
                inner = [f"{node.module}.{alias.name}" for alias in node.names]
                names |= {each if each in modules else str(node.module) for each in inner}
        found[name] = (names & modules.keys()) - {name}
    return found


def _circles(imported: dict[str, set[str]]) -> list[set[str]]:
    """Return the sets of modules that import one another: the strongly connected components of more than one."""
    reached = {name: _reach(imported, name) for name in imported}
    circles = [{name} | {other for other in reached[name] if name in reached[other]} for name in sorted(imported)]
    return [circle for place, circle in enumerate(circles) if len(circle) > 1 and circle not in circles[:place]]


def _reach(imported: dict[str, set[str]], start: str) -> set[str]:
    """Modules that a module imports, directly or by way of others."""
    seen: set[str] = set()
    ahead = [start]
    while ahead:
        new = imported[ahead.pop()] - seen
        seen |= new
        ahead += new
    return seen


def test_no_modules_import_one_another_in_a_circle() -> None:
    circles = _circles(_imported(_modules(SOURCE)))
    new = [circle for circle in circles if circle not in CIRCLES]
    assert not new, f"modules that import one another: {[sorted(circle) for circle in new]}"
    gone = [circle for circle in CIRCLES if circle not in circles]
    assert not gone, f"no circle any more, to be taken off the list: {[sorted(circle) for circle in gone]}"


def test_a_circle_is_found_wherever_the_import_stands(tmp_path: Path) -> None:
    files = {
        "__init__": "",
        "one": "from pack.two import x",
        "two": "def f():\n    from pack import three",
        "three": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import pack.one",
        "four": "from pack.one import y",
    }
    folder = tmp_path / "pack"
    folder.mkdir()
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text)
    assert _circles(_imported(_modules(folder))) == [{"pack.one", "pack.two", "pack.three"}]


def test_every_public_name_can_be_imported_and_is_listed() -> None:
    assert tatamu.__all__ == sorted(tatamu.__all__)
    assert set(tatamu.__all__) == set(tatamu._HOME)
    for name in tatamu.__all__:
        assert getattr(tatamu, name).__module__.startswith("tatamu.")
