"""The table of symbols of the embedded simulator names what there is."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

from tatamu.simulation.native.memory.kernel_cache import NATIVE

NAME = "tatamu.simulation.native."


def test_the_symbol_table_names_only_what_there_is() -> None:
    text = (Path(__file__).parent.parent / "docs" / "theory" / "native-symbols.md").read_text()
    files = [file.relative_to(NATIVE).with_suffix("") for file in NATIVE.rglob("*.py") if file.stem != "__init__"]
    names = [".".join(file.parts) for file in files]
    records = {k: v for name in names for k, v in vars(import_module(NAME + name)).items() if isinstance(v, type)}
    for name, field in re.findall(r"`([A-Z]\w+)\.(\w+)`", text):
        assert hasattr(records[name], field) or field in records[name].__annotations__, f"{name}.{field}"
    for place in re.findall(r"`((?:contact|elastic|memory)\.\w+)", text):
        assert place in names, place
    assert len(re.findall(r"`[A-Z]\w+\.\w+`", text)) > 15
