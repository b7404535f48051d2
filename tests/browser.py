"""A headless Chromium, which Playwright drives; without one, tests are skipped aloud."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = [
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--force-color-profile=srgb",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]
PATIENCE = 120_000.0
"""How long one answer may take [ms]; WebGL in software on a busy machine is slow."""
BEYOND = """(() => {
  const scrolls = (e) => e !== document.documentElement
    && (getComputedStyle(e).overflowX !== "visible" || scrolls(e.parentElement));
  const all = [...document.querySelectorAll("body *")];
  const far = all.filter((e) => e.getBoundingClientRect().right > innerWidth + 1 && !scrolls(e.parentElement));
  return [document.documentElement.scrollWidth > innerWidth, ...far.map((e) => e.outerHTML.slice(0, 80))];
})()"""
"""Whether the page is wider than the window, and what stands out of it where nothing scrolls."""
CUT = """(() => [...document.querySelectorAll(".chart")].flatMap((e) => {
  const place = e.getBoundingClientRect();
  const words = [...e.querySelectorAll("svg text")].filter((t) => t.textContent.trim());
  return words.filter((t) => { const box = t.getBoundingClientRect();
    return box.left < place.left - 2 || box.right > place.right + 2; }).map((t) => t.textContent.slice(0, 60));
}))()"""
"""Words of charts that are cut at the left or right."""
PAPER = """(() => getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number))()"""
TEXTS = """(() => [...document.querySelectorAll("p, td, th, li, h1, h2, code, dt, dd, figcaption")]
  .filter((e) => e.textContent.trim())
  .map((e) => getComputedStyle(e).color.match(/\\d+/g).slice(0, 3).map(Number)))()"""

Phone = Callable[[str | Path], None]


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    program = next((path for name in NAMES if (path := shutil.which(name))), None)
    if program is None:
        pytest.skip("no Chromium found, so no page was opened in a browser")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield running
        running.close()


@pytest.fixture
def phone(chromium: Browser, tmp_path: Path) -> Phone:
    """Check that a page fits a phone, by day and by night: nothing scrolls sideways, nothing is cut, all is seen."""

    def check(page: str | Path) -> None:
        file = page if isinstance(page, Path) else tmp_path / "phone.html"
        if isinstance(page, str):
            file.write_text(page)
        for scheme in ("light", "dark"):
            context = chromium.new_context(
                viewport={"width": 390, "height": 844}, color_scheme=scheme, reduced_motion="reduce"
            )
            tab = context.new_page()
            tab.set_default_timeout(PATIENCE)
            tab.goto(file.resolve().as_uri())
            tab.evaluate("window.tatamu.ready")
            assert tab.evaluate(BEYOND) == [False]
            assert tab.evaluate(CUT) == []
            paper = sum(tab.evaluate(PAPER)[:3]) / 3
            assert paper > 200 if scheme == "light" else paper < 50
            texts = [sum(colour) / 3 for colour in tab.evaluate(TEXTS)]
            assert all(abs(text - paper) > 60 for text in texts), "some text is hardly seen"
            context.close()

    return check
