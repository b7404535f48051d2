"""The notebooks of the site run, and what they show is shown; `make docs` runs them as notebooks, and renders them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tatamu import Result

NOTEBOOKS = Path(__file__).parent.parent / "docs" / "notebooks"
CELL = re.compile(r"^```\{code-cell\} python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def run(name: str) -> dict[str, Any]:
    """Names that the cells of a notebook define."""
    names: dict[str, Any] = {}
    for cell in CELL.findall((NOTEBOOKS / f"{name}.md").read_text()):
        exec(compile(cell, f"{name}.md", "exec"), names)
    return names


def test_the_first_fold_shows_itself() -> None:
    result = run("first-fold")["result"]
    assert isinstance(result, Result)
    shown = result._repr_html_()
    assert shown == result._repr_html_()
    assert "<strong>Towel, half fold</strong>: " in shown and 'src="data:image/png;base64,' in shown
    assert f"{1e3 * result.score.mean_vertex_distance:.1f}&nbsp;mm" in shown
    (frame,) = re.findall(r'<iframe [^>]*sandbox="allow-scripts"[^>]*srcdoc="([^"]*)"', shown)
    assert "replay-data" in frame and "<header" not in frame


CHECKS: dict[str, Callable[[dict[str, Any]], bool]] = {
    "your-garment": lambda names: names["skirt"].layers == 2 and names["result"].final.shape[1] == 3,
    "your-cloth": lambda names: names["task"].garment.material == names["found"].material,
    "your-robot": lambda names: all(check.ok for check in names["planned"].plan.checks.values()),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CHECKS)
def test_the_other_notebooks_come_to_what_they_say(name: str) -> None:
    assert CHECKS[name](run(name))


def test_every_notebook_is_tested() -> None:
    assert {path.stem for path in NOTEBOOKS.glob("*.md")} == {"first-fold", *CHECKS}
