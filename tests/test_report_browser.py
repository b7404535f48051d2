"""Pages in a headless Chromium: they load without complaint, and the slider moves the cloth.

Playwright drives the Chromium of the machine; without one these tests are skipped aloud.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from tatamu.folding.advice import choices
from tatamu.garments import make_garment
from tatamu.report.candidates import page as candidates_page
from tatamu.report.garment import page as garment_page
from tatamu.simulation.rollout import Rollout
from tests.browser import PATIENCE, Phone
from tests.fabricated import TIMING, changed, report, rewritten, write_fold
from tests.fakes import subject
from tests.physics import validate
from tests.physics.page import page as validation_page

PIXELS = """(() => {
  const gl = document.querySelector("canvas").getContext("webgl2");
  const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  const all = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all);
  const some = [];
  for (let i = 0; i < all.length; i += 4 * 7) some.push(all[i], all[i + 1], all[i + 2]);
  return some;
})()"""


class Tab:
    """A page of the browser and what it complained of: errors, warnings, and requests to any network."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.complaints: list[str] = []
        page.set_default_timeout(PATIENCE)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("console", self._console)
        page.on("request", self._request)

    def _console(self, message: Any) -> None:
        if message.type in ("error", "warning", "assert"):
            self.complaints.append(message.text)

    def _request(self, request: Any) -> None:
        if not request.url.startswith(("file:", "data:", "blob:")):
            self.complaints.append(f"request: {request.url}")

    def open(self, path: Path, fragment: str = "") -> None:
        """Open a page and wait until it is ready."""
        self.page.goto(path.resolve().as_uri() + fragment)
        self.run("window.tatamu.ready")

    def run(self, script: str) -> Any:
        """The value of a JavaScript expression; a promise is waited for."""
        return self.page.evaluate(script)

    def settle(self) -> None:
        """Wait until what was asked for has been drawn."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def slide(self, time: float) -> None:
        """Move the slider as a person does, and wait for the picture."""
        self.run(
            "(() => { const s = document.querySelector('[data-part=slider]');"
            f"s.value = {round(1000 * time)}; s.dispatchEvent(new Event('input', {{bubbles: true}})); }})()"
        )
        self.settle()

    def press(self, key: str) -> None:
        """Press a key where the focus is."""
        self.page.keyboard.press(key)
        self.settle()

    def state(self) -> dict[str, Any]:
        """What the replay shows."""
        value: dict[str, Any] = self.run("tatamu.state()")
        return value

    def pixels(self) -> np.ndarray:
        """Some pixels of the replay, shape (p, 3)."""
        return np.array(self.run(PIXELS)).reshape(-1, 3)


Opener = Callable[..., Tab]


@pytest.fixture
def tab(chromium: Browser) -> Iterator[Opener]:
    """Opens tabs; options are those of Playwright's contexts."""
    contexts = []

    def opened(width: int = 900, height: int = 700, **options: Any) -> Tab:
        contexts.append(chromium.new_context(viewport={"width": width, "height": height}, **options))
        return Tab(contexts[-1].new_page())

    yield opened
    for context in contexts:
        context.close()


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report(write_fold(tmp_path_factory.mktemp("fold") / "towel", spacing=0.05, frames=47))


def near(seen: np.ndarray, colour: tuple[int, int, int], reach: int = 60) -> float:
    """Share of the pixels that are about of a colour."""
    return float((np.abs(seen - colour).max(axis=1) < reach).mean())


def test_the_page_loads_without_complaint_and_draws_every_figure(tab: Opener, reported: Path) -> None:
    browser = tab()
    browser.open(reported)
    assert browser.complaints == []
    assert browser.run("document.querySelector('#replay').dataset.failed === undefined")
    count = "[...document.querySelectorAll('.chart')].map(c => c.querySelectorAll('svg').length)"
    charts = browser.run(count)
    assert len(charts) == 8 and min(charts) > 0
    assert browser.run("document.querySelectorAll('.three svg image').length") == 3


def test_no_script_runs_but_those_of_the_page(tab: Opener, reported: Path, tmp_path: Path) -> None:
    """As if a text from a file had come into the page without being escaped."""
    evil = (
        "<base href='https://example.org/'><script>window.evil = 1</script><img src='data:,' onerror='window.evil = 1'>"
    )
    planted = tmp_path / "planted.html"
    planted.write_text(
        reported.read_text().replace("<main>", f"<main>{evil}<a id='link' href='javascript:window.evil = 1'>x</a>")
    )
    browser = tab()
    browser.open(planted)
    browser.run("document.getElementById('link').click()")
    browser.settle()
    assert browser.run("window.evil === undefined && document.baseURI.startsWith('file:')")
    assert len(browser.complaints) >= 3 and all("Content Security Policy" in text for text in browser.complaints)


def test_the_slider_moves_the_cloth(tab: Opener, reported: Path) -> None:
    browser = tab()
    browser.open(reported, "#t=0")
    browser.settle()
    rollout = Rollout.load(reported.parent / "rollout.npz")
    seen = []
    last = len(rollout.times) - 1
    for frame in (0, last // 2, last):  # between frames the page interpolates
        time = float(rollout.times[frame])
        browser.slide(time)
        now = browser.state()
        assert now["time"] == pytest.approx(time, abs=0.02)
        assert np.allclose(now["centroid"], rollout.positions[frame].mean(axis=0), atol=2e-4)
        seen.append(browser.pixels())
    for before, after in pairwise(seen):
        assert (np.abs(before - after).max(axis=1) > 40).mean() > 0.02
    clock = browser.run("document.querySelector('[data-part=clock]').textContent")
    assert clock == "4.20 s / 4.20 s"
    assert browser.complaints == []


def test_the_cloth_has_two_colours(tab: Opener, reported: Path) -> None:
    browser = tab()
    browser.open(reported, "#t=0")
    browser.run("document.querySelector('[data-show=target]').click()")
    front, back = (70, 110, 190), (250, 195, 125)
    browser.slide(0.0)
    flat = browser.pixels()
    browser.slide(TIMING["ends"])
    folded = browser.pixels()
    assert near(flat, front) > 0.05 and near(flat, front) > 5 * near(folded, front)
    assert near(folded, back) > 0.03 and near(folded, back) > 3 * near(flat, back)


def test_the_back_of_a_garment_has_a_colour_of_its_own(tab: Opener, tmp_path: Path) -> None:
    """Cloth whose triangles face down as it lies: a back, that shows its inside, and turned its outside."""
    folder = write_fold(tmp_path, spacing=0.05, frames=47)
    changed(folder / "scene.json", lambda value: [face.reverse() for face in value["cloth"]["faces"]])
    rewritten(folder, lambda arrays: arrays.update(faces=np.ascontiguousarray(arrays["faces"][:, ::-1])))
    browser = tab()
    browser.open(report(folder), "#t=0")
    browser.run("document.querySelector('[data-show=target]').click()")
    inside, outside = (250, 195, 125), (185, 215, 250)
    browser.slide(0.0)
    flat = browser.pixels()
    browser.slide(TIMING["ends"])
    folded = browser.pixels()
    assert near(flat, inside, 40) > 0.05 and near(flat, inside, 40) > 5 * near(folded, inside, 40)
    assert near(folded, outside, 25) > 0.03 and near(folded, outside, 25) > 3 * near(flat, outside, 25)
    assert "outside of the back" in browser.run("document.querySelector('.legend').textContent")
    assert browser.complaints == []


def test_every_switch_and_view_changes_the_picture(tab: Opener, reported: Path) -> None:
    browser = tab()
    browser.open(reported, "#t=1.6")
    browser.settle()
    last = browser.pixels()
    names = ["show=target", "show=paths", "show=error", "view=top", "view=side", "view=three"]
    for name, share in zip(names, (0.001, 0.001, 0.01, 0.05, 0.05, 0.05), strict=True):
        browser.run(f"document.querySelector('[data-{name}]').click()")
        browser.settle()
        now = browser.pixels()
        assert (np.abs(now - last).max(axis=1) > 15).mean() > share, name
        last = now


def test_the_replay_plays_once_and_the_keys_work(tab: Opener, reported: Path) -> None:
    browser = tab()
    browser.open(reported, "#t=4.1")
    browser.run("document.querySelector('canvas').focus()")
    assert not browser.state()["running"]
    browser.press(" ")
    ended = browser.run(
        "new Promise(done => { const look = () => tatamu.state().running ? setTimeout(look, 50)"
        " : done(tatamu.state()); look(); })"
    )
    assert ended["time"] == pytest.approx(TIMING["ends"])
    browser.run("document.querySelector('[data-part=rate]').value = 0.25")
    browser.run("document.querySelector('[data-part=rate]').dispatchEvent(new Event('change'))")
    browser.press(" ")
    assert browser.state()["running"]
    browser.press(" ")
    stopped = browser.state()
    assert not stopped["running"] and stopped["time"] < 4.5
    browser.press("Home")
    assert browser.state()["time"] == 0.0
    browser.press(".")
    assert browser.state()["time"] == pytest.approx(1 / 30)
    before = browser.pixels()
    browser.press("ArrowLeft")
    assert (browser.pixels() != before).any()
    assert browser.complaints == []


def test_a_reader_who_wants_less_motion_gets_none(tab: Opener, reported: Path) -> None:
    browser = tab(reduced_motion="reduce")
    browser.open(reported)
    assert not browser.state()["running"]


def test_day_and_night_have_their_own_colours(tab: Opener, reported: Path) -> None:
    browser = tab(color_scheme="light")
    browser.open(reported, "#t=1")
    colour = "getComputedStyle(document.querySelector('.chart .xtick text')).fill"
    day, table = browser.run(colour), browser.pixels()
    browser.page.emulate_media(color_scheme="dark")
    browser.settle()
    browser.page.wait_for_function(f"{colour} !== '{day}'")
    browser.settle()
    assert (np.abs(table - browser.pixels()).max(axis=1) > 60).mean() > 0.1
    assert browser.complaints == []


def test_the_page_never_scrolls_sideways(tab: Opener, reported: Path) -> None:
    for width in (360, 768, 1600):
        browser = tab(width, 800, is_mobile=width < 500)
        browser.open(reported, "#t=1")
        browser.settle()
        assert browser.run("document.documentElement.scrollWidth") <= width


def test_a_poor_study_shows_without_complaint(tab: Opener, tmp_path: Path) -> None:
    """One trial, no baselines, no moments of the search, no table, no timing, a name like a script."""
    browser = tab()
    folder = write_fold(tmp_path / "poor", spacing=0.08, frames=5, count=1, size=0.03)
    result = json.loads((folder / "result.json").read_text())
    del result["baselines"], result["task"]["translation"], result["task"]["size"]
    result["task"]["garment"] = "<img src=x onerror=alert(1)>"
    (folder / "result.json").write_text(json.dumps(result))
    manipulation = json.loads((folder / "manipulation.json").read_text())
    del manipulation["timing"]
    (folder / "manipulation.json").write_text(json.dumps(manipulation))
    scene = json.loads((folder / "scene.json").read_text())
    (folder / "scene.json").write_text(json.dumps(scene | {"table": None}))
    rollout = Rollout.load(folder / "rollout.npz")
    extra = {"target": rollout.extra["target"]}
    Rollout(rollout.times, rollout.positions, rollout.faces, rollout.info, extra).save(folder / "rollout.npz")
    browser.open(report(folder), "#t=1")
    browser.settle()
    assert browser.complaints == []
    title = browser.run("document.querySelector('h1').textContent")
    assert title == "<img src=x onerror=alert(1)>, half fold"
    assert browser.run("document.querySelector('.pill').textContent") == "failed"


def test_without_webgl_the_rest_of_the_page_still_works(tab: Opener, reported: Path) -> None:
    browser = tab()
    hidden = """const before = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
      return kind === "webgl2" ? null : before.call(this, kind, ...more);
    };"""
    browser.page.add_init_script(hidden)
    browser.open(reported)
    assert "WebGL 2" in browser.run("document.querySelector('[data-part=failure]').innerText")
    assert browser.run("document.querySelectorAll('.chart svg').length") > 0


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Pages without a replay: one of charts and tables, one of a drawing."""
    folder = tmp_path_factory.mktemp("pages")
    falling = subject(lambda scene, time: scene.cloth.vertices - [0.0, 0.0, 0.5 * scene.gravity * time**2])
    written = {
        "validation": validation_page(validate(falling, ["fall"])),
        "garment": garment_page(make_garment("towel")),
    }
    for name, text in written.items():
        (folder / f"{name}.html").write_text(text)
    return {name: folder / f"{name}.html" for name in written}


@pytest.mark.parametrize("name", ["validation", "garment"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_other_pages_fit_a_phone_and_follow_day_and_night(
    tab: Opener, pages: dict[str, Path], name: str, scheme: str
) -> None:
    browser = tab(360, 800, is_mobile=True, color_scheme=scheme)
    browser.open(pages[name])
    assert browser.complaints == []
    assert browser.run("document.documentElement.scrollWidth") <= 360
    ground, ink = (
        sum(int(part) for part in re.findall(r"\d+", browser.run(script)))
        for script in (
            "getComputedStyle(document.body).backgroundColor",
            "getComputedStyle(document.querySelector('.chart .xtick text, figure svg text')).fill",
        )
    )
    assert ink - ground > 300 if scheme == "dark" else ground - ink > 300, "words stand out from the ground"


@pytest.fixture(scope="module")
def every_page(reported: Path, pages: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A page of each kind that is quickly made."""
    hoodie = make_garment("examples/garments/hoodie.toml", spacing=0.05)
    plans = tmp_path_factory.mktemp("plans") / "plans.html"
    plans.write_text(candidates_page(hoodie, choices(hoodie)[:2]))
    return {"report": reported, "plans": plans, **pages}


@pytest.mark.parametrize("name", ["report", "garment", "plans", "validation"])
def test_a_page_fits_a_phone_and_follows_day_and_night(every_page: dict[str, Path], name: str, phone: Phone) -> None:
    phone(every_page[name])


def test_a_long_verdict_fits_a_phone(tab: Opener, reported: Path, phone: Phone) -> None:
    words = "succeeds in 22 of 36 simulations (61 %, 95 % interval 43 to 77 %)"
    phone(re.sub(r'(<span class="pill large[^>]*>)[^<]*', rf"\g<1>{words}", reported.read_text()))


@pytest.mark.parametrize("width", [360, 390, 900])
def test_names_of_events_do_not_touch(tab: Opener, tmp_path: Path, width: int) -> None:
    folder = write_fold(tmp_path, spacing=0.08, frames=24)
    browser = tab(width, 844, reduced_motion="reduce")
    browser.open(report(folder))
    boxes = "[...document.querySelectorAll('.events span')].map(e => e.getBoundingClientRect().toJSON())"
    places = browser.run(boxes)
    assert len(places) == 3
    for one, other in pairwise(sorted(places, key=lambda place: float(place["left"]))):
        apart = other["left"] - one["right"]
        assert apart > 4 or min(one["bottom"], other["bottom"]) <= max(one["top"], other["top"]) + 0.5


def test_words_in_a_drawing_can_be_read_on_a_phone(tab: Opener, pages: dict[str, Path]) -> None:
    browser = tab(390, 844)
    browser.open(pages["garment"])
    heights = browser.run("[...document.querySelectorAll('svg text')].map(e => e.getBoundingClientRect().height)")
    assert min(heights) > 8
