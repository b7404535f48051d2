"""Writes the results of all tests on real cloth as an HTML page that opens without a network."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from studies.real_cloth.section import Section
from tatamu.show.page import render


def page(sections: Sequence[Section], simulator: str) -> str:
    """Return the page with the results of all tests on real cloth as HTML."""
    return render(
        Path(__file__).with_name("page.html"),
        charts={section.name: list(section.charts) for section in sections},
        title=f"Real cloth, simulated by {simulator}",
        sections=sections,
    )
