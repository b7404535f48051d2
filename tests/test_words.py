"""The words of code and docs: equations are cited in one form."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MODULES = sorted(file for folder in ("src", "studies") for file in (ROOT / folder).rglob("*.py"))
PROSE = [*MODULES, *sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
ELSEWISE = re.compile(
    r"""
    \b[Ee]qs\b                                  # Eqs. (10) and (11)
    | \b[Ee]q\.?\s(?!\(\d+\))                   # Eq. 12, Eq 12, Eq.~12
    | \b[Ee]q\.\(                               # Eq.(12)
    | \beq\.                                    # eq. (12)
    | \bEq\s\(                                  # Eq (12)
    | \b[Ee]quations?\s\(?\d                    # equation (12), equation 12
    | \bEq\.\s\(\d+\)(?:,|\sand|\sto)\s\(\d+\)  # Eq. (10), (11); Eq. (10) to (13): a search for the last finds nothing
    """,
    re.VERBOSE,
)
"""A citation of one of the paper's equations in another form than `Eq. (12)`."""


def citations(text: str) -> list[str]:
    """What stands around every citation in another form."""
    return [text[max(0, found.start() - 20) : found.end() + 20] for found in ELSEWISE.finditer(text)]


def test_equations_of_the_paper_are_cited_in_one_form() -> None:
    found = [f"{file.relative_to(ROOT)}: {words!r}" for file in PROSE for words in citations(file.read_text())]
    assert not found, "\n".join(found)


OTHER_FORMS = [
    "Eq. 12",
    "Eqs. (1) and (2)",
    "equation (12)",
    "Equation 12",
    "eq. (12)",
    "Eq.(12)",
    "Eq (12)",
    "Eq. (1) to (3)",
]


@pytest.mark.parametrize("text", OTHER_FORMS)
def test_other_forms_are_found(text: str) -> None:
    assert citations(f"as {text} says")
    assert not citations("as Eq. (12) says, with Eq. (13)")


def test_every_equation_of_the_paper_is_found_by_one_search() -> None:
    docs = "".join(file.read_text() for file in PROSE if file.suffix == ".md")
    assert all(f"Eq. ({number})" in docs for number in range(1, 14))
