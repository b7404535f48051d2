"""The report in a headless Chromium: it loads without complaint, and the slider moves the cloth."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.report import write_report
from tatamu.rollout import Rollout
from tests.browser import Browser, find
from tests.fabricated import write_fold

PIXELS = """(() => {
  const gl = document.querySelector("canvas").getContext("webgl2");
  const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  const all = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all);
  const some = [];
  for (let i = 0; i < all.length; i += 4 * 7) some.push(all[i], all[i + 1], all[i + 2]);
  return some;
})()"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = find()
    if program is None:
        pytest.skip("no Chromium found, so the report was not opened in a browser")
    with Browser(program) as running:
        running.size(900, 700)
        yield running


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(write_fold(tmp_path_factory.mktemp("fold") / "towel", spacing=0.05, frames=47))


def slide(browser: Browser, time: float) -> None:
    """Move the slider as a person does, and wait for the picture."""
    browser.run(
        "(() => { const s = document.querySelector('[data-part=slider]');"
        f"s.value = {round(1000 * time)}; s.dispatchEvent(new Event('input', {{bubbles: true}})); }})()"
    )
    browser.settle()


def press(browser: Browser, key: str) -> None:
    """Press a key where the focus is."""
    text = {"text": key} if len(key) == 1 else {}
    browser.call("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
    browser.call("Input.dispatchKeyEvent", type="keyUp", key=key)
    browser.settle()


def state(browser: Browser) -> dict[str, Any]:
    value: dict[str, Any] = browser.run("tatamu.state()")
    return value


def pixels(browser: Browser) -> np.ndarray:
    return np.array(browser.run(PIXELS)).reshape(-1, 3)


def near(seen: np.ndarray, colour: tuple[int, int, int], reach: int = 60) -> float:
    """Share of the pixels that are about of a colour."""
    return float((np.abs(seen - colour).max(axis=1) < reach).mean())


def test_the_page_loads_without_complaint_and_draws_every_figure(browser: Browser, report: Path) -> None:
    browser.open(report)
    assert browser.complaints() == []
    assert browser.run("document.querySelector('#replay').dataset.failed === undefined")
    count = "[...document.querySelectorAll('.chart')].map(c => c.querySelectorAll('svg').length)"
    charts = browser.run(count)
    assert len(charts) == 8 and min(charts) > 0
    assert browser.run("document.querySelectorAll('.three svg image').length") == 3


def test_the_slider_moves_the_cloth(browser: Browser, report: Path) -> None:
    browser.open(report, "#t=0")
    browser.settle()
    rollout = Rollout.load(report.parent / "rollout.npz")
    seen = []
    for time in (0.0, 2.0, 4.6):
        slide(browser, time)
        now = state(browser)
        frame = int(np.argmin(np.abs(rollout.times - time)))
        assert now["time"] == pytest.approx(time, abs=0.02)
        assert np.allclose(now["centroid"], rollout.positions[frame].mean(axis=0), atol=2e-4)
        seen.append(pixels(browser))
    for before, after in pairwise(seen):
        assert (np.abs(before - after).max(axis=1) > 40).mean() > 0.02
    clock = browser.run("document.querySelector('[data-part=clock]').textContent")
    assert clock == "4.60 s / 4.60 s"
    assert browser.complaints() == []


def test_the_cloth_has_two_colours(browser: Browser, report: Path) -> None:
    browser.open(report, "#t=0")
    browser.run("document.querySelector('[data-show=target]').click()")
    front, back = (70, 110, 190), (250, 195, 125)
    slide(browser, 0.0)
    flat = pixels(browser)
    slide(browser, 4.6)
    folded = pixels(browser)
    assert near(flat, front) > 0.05 and near(flat, front) > 5 * near(folded, front)
    assert near(folded, back) > 0.03 and near(folded, back) > 3 * near(flat, back)


def test_every_switch_and_view_changes_the_picture(browser: Browser, report: Path) -> None:
    browser.open(report, "#t=1.6")
    browser.settle()
    last = pixels(browser)
    names = ["show=target", "show=paths", "show=error", "view=top", "view=side", "view=three"]
    for name, share in zip(names, (0.001, 0.001, 0.01, 0.05, 0.05, 0.05), strict=True):
        browser.run(f"document.querySelector('[data-{name}]').click()")
        browser.settle()
        now = pixels(browser)
        assert (np.abs(now - last).max(axis=1) > 15).mean() > share, name
        last = now


def test_the_replay_plays_once_and_the_keys_work(browser: Browser, report: Path) -> None:
    browser.open(report, "#t=4.5")
    browser.run("document.querySelector('canvas').focus()")
    assert not state(browser)["running"]
    press(browser, " ")
    ended = browser.run(
        "new Promise(done => { const look = () => tatamu.state().running ? setTimeout(look, 50)"
        " : done(tatamu.state()); look(); })"
    )
    assert ended["time"] == pytest.approx(4.6)
    browser.run("document.querySelector('[data-part=rate]').value = 0.25")
    browser.run("document.querySelector('[data-part=rate]').dispatchEvent(new Event('change'))")
    press(browser, " ")
    assert state(browser)["running"]
    press(browser, " ")
    stopped = state(browser)
    assert not stopped["running"] and stopped["time"] < 4.5
    press(browser, "Home")
    assert state(browser)["time"] == 0.0
    press(browser, ".")
    assert state(browser)["time"] == pytest.approx(1 / 30)
    before = pixels(browser)
    press(browser, "ArrowLeft")
    assert (pixels(browser) != before).any()
    assert browser.complaints() == []


def test_a_reader_who_wants_less_motion_gets_none(browser: Browser, report: Path) -> None:
    browser.prefer(prefers_reduced_motion="reduce")
    browser.open(report)
    browser.prefer()
    assert not state(browser)["running"]


def test_day_and_night_have_their_own_colours(browser: Browser, report: Path) -> None:
    browser.prefer(prefers_color_scheme="light")
    browser.open(report, "#t=1")
    colour = "getComputedStyle(document.querySelector('.chart .xtick text')).fill"
    day, table = browser.run(colour), pixels(browser)
    browser.prefer(prefers_color_scheme="dark")
    browser.settle()
    night = browser.run(f"new Promise(done => setTimeout(() => done({colour}), 500))")
    assert day != night
    assert (np.abs(table - pixels(browser)).max(axis=1) > 60).mean() > 0.1
    browser.prefer()
    assert browser.complaints() == []


def test_the_page_never_scrolls_sideways(browser: Browser, report: Path) -> None:
    for width in (360, 768, 1600):
        browser.size(width, 800, phone=width < 500)
        browser.open(report, "#t=1")
        browser.settle()
        assert browser.run("document.documentElement.scrollWidth") <= width
    browser.size(900, 700)


def test_a_poor_study_shows_without_complaint(browser: Browser, tmp_path: Path) -> None:
    """One trial, no baselines, no moments of the search, no table, no timing, a name like a script."""
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
    browser.open(write_report(folder), "#t=1")
    browser.settle()
    assert browser.complaints() == []
    title = browser.run("document.querySelector('h1').textContent")
    assert title == "<img src=x onerror=alert(1)>, half fold"
    assert browser.run("document.querySelector('.pill').textContent") == "failed"


def test_without_webgl_the_rest_of_the_page_still_works(browser: Browser, report: Path) -> None:
    hidden = """const before = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
      return kind === "webgl2" ? null : before.call(this, kind, ...more);
    };"""
    script = browser.call("Page.addScriptToEvaluateOnNewDocument", source=hidden)["identifier"]
    browser.open(report)
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
    assert "WebGL 2" in browser.run("document.querySelector('[data-part=failure]').innerText")
    assert browser.run("document.querySelectorAll('.chart svg').length") > 0
