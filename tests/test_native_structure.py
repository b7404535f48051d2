"""The rooms of the embedded simulator: imports point one way, and none goes around in a circle."""

from __future__ import annotations

import ast
import re
from graphlib import TopologicalSorter
from importlib import import_module
from pathlib import Path

from tatamu.simulation.native.compiled import NATIVE

NAME = "tatamu.simulation.native."
ORDER = [
    ["addresses", "compiled", "options"],
    ["geometry", "lattice"],
    ["bands"],
    ["elastic", "contact"],
    ["air", "led_bodies"],
    ["model"],
    ["system"],
    ["among_bodies", "grippers", "step"],
    ["kernels", "snapshot"],
    ["precompile"],
    ["simulation"],
]
"""Each room may import itself and those in lines above; those in one line know nothing of one another."""


def _imports() -> dict[str, set[str]]:
    """Modules of the simulator, and which others of it each imports."""
    modules = {".".join(f.relative_to(NATIVE).with_suffix("").parts): f for f in NATIVE.rglob("*.py")}
    found = {}
    for module, file in modules.items():
        names = set()
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module and (node.module + ".").startswith(NAME):
                base = node.module.removeprefix(NAME.rstrip(".")).removeprefix(".")
                inner = [f"{base}.{alias.name}".removeprefix(".") for alias in node.names]
                names |= {name if name in modules else base for name in inner}
        found[module] = names - {module, ""}
    return found


def test_rooms_know_only_what_is_below_them() -> None:
    rank = {room: number for number, rooms in enumerate(ORDER) for room in rooms}
    for module, imported in _imports().items():
        own = module.split(".")[0]
        for name in imported:
            room = name.split(".")[0]
            assert own == "__init__" or room == own or rank[room] < rank[own], f"{module} imports {name}"


def test_every_room_has_its_place_in_the_order() -> None:
    rooms = {module.split(".")[0] for module in _imports()} - {"__init__"}
    assert rooms == {room for rooms in ORDER for room in rooms}


def test_no_module_imports_itself_by_way_of_others() -> None:
    order = list(TopologicalSorter(_imports()).static_order())
    assert order.index("contact.state") < order.index("contact.gauss_seidel") < order.index("step")


def test_the_symbol_table_names_only_what_there_is() -> None:
    text = (Path(__file__).parent.parent / "docs" / "theory" / "native-symbols.md").read_text()
    modules = [import_module(NAME + module) for module in _imports() if not module.endswith("__init__")]
    records = {name: found for module in modules for name, found in vars(module).items() if isinstance(found, type)}
    for name, field in re.findall(r"`([A-Z]\w+)\.(\w+)`", text):
        assert hasattr(records[name], field) or field in records[name].__annotations__, f"{name}.{field}"
    for place in re.findall(r"`((?:contact|elastic)\.\w+|bands\b)", text):
        assert place in _imports(), place
    assert len(re.findall(r"`[A-Z]\w+\.\w+`", text)) > 15
