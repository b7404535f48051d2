"""The sections as one page that opens offline."""

from __future__ import annotations

from collections.abc import Sequence

from tatamu.presentation.page import render
from tatamu.validation.real.section import Section


def page(sections: Sequence[Section], simulator: str) -> str:
    """The whole page as HTML."""
    return render(
        "validation/real/page.html",
        charts={section.name: list(section.charts) for section in sections},
        title=f"Real cloth, simulated by {simulator}",
        sections=sections,
    )
