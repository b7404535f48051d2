"""Pictures and captures of the docs: gallery, moving picture, what commands print.

    python -m benchmarks.gallery --out runs/gallery [--only robots --only captures]

A command whose result is there already is not run again, so that an interrupted run goes on. Films need OpenGL
(`MUJOCO_GL=egl` without a screen), and screenshots the Chromium of Playwright.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

from benchmarks.tables import IMAGES, publish

TATAMU = str(Path(sys.executable).with_name("tatamu"))
QUICK = "--trials 12 --disturbances none --no-baselines"
GARMENTS = {
    "towel": ("Towel in half", "learn towel"),
    "towel-quarters": ("Towel in quarters", "learn towel --fold quarters"),
    "tshirt-half": ("T-shirt in half", "learn tshirt --fold half"),
    "trousers-leg": ("Trousers, leg over leg", "learn trousers --fold leg"),
    "trousers-half": ("Trousers in half", "learn trousers --fold half"),
}
"""Title of each learned fold, and the command without the options of `QUICK` and `--out`."""
LARGE = "learn towel --robot panda-pair --trials 10 --disturbances none"
SMALL = "learn towel --size 0.30x0.36 --robot hironx --trials 6 --disturbances none --no-baselines"
ROBOTS = {
    "panda-pair": ("large", LARGE),
    "fr3-pair": ("large", LARGE),
    "ur5e-pair": ("large", LARGE),
    "xarm7-pair": ("large", LARGE),
    "hironx": ("small", SMALL),
    "nextage": ("small", SMALL),
    "aloha2": ("aloha2", "learn towel --size 0.34x0.40 --robot aloha2 --trials 6 --no-baselines"),
    "openarm": ("openarm", "learn towel --size 0.30x0.24 --robot openarm --trials 6 --no-baselines"),
    "so101-pair": ("so101", "learn towel --size 0.24x0.24 --hands 1 --robot so101-pair --trials 6 --no-baselines"),
}
"""Folder of the fold that each robot makes, and the command that learns it."""
HERO = "panda-pair"
"""Robot of the moving picture."""
MIDDLE = 0.55
"""Moment of the film that is shown as a picture, as a fraction of its length."""
ENVIRONMENTS = {"Hands-v0": (0.1, 0.2, 0.32), "Fold-v0": (1.0,)}
"""Moments of an episode that are shown, as fractions of its length."""
CAPTURES = {
    "learn": ("learn towel --out towel", "towel"),
    "plan": (f"plan large --robot {HERO} --out large-{HERO}", f"large-{HERO}"),
    "rehearse": (f"rehearse large-{HERO} --simulator native", f"large-{HERO}/rehearsal"),
    "calibrate": ("calibrate measurements-towel.toml --out my-towel.toml", "my-towel.toml"),
    "margins": ("margins small --draws 20", "small/margins"),
    "check": ("check small --simulator native --halve", "small/check-native.json"),
    "observe": ("observe towel --left 12,-3 --right 8,4 --slip 2,0", "towel/observed"),
}
"""Command of each captured output, and the file or folder that it writes."""
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""Options of Chromium, which draws replays without a graphics card."""
PROGRESS = re.compile(r"\d+/\d+ |about |laying out ")
"""Beginning of lines that only show how far a command is."""
SHOTS = {"report": "towel/report.html", "margins": "small/margins/margins.html", "calibrated": "my-towel.html"}
"""Pages of which a screenshot is shown."""


def run(command: str, out: Path, made: str) -> str:
    """Run a command of tatamu in the folder, unless it has written its result; return what it prints."""
    kept = out / "printed" / f"{made.replace('/', '-')}.txt"
    if not kept.exists():
        print(f"tatamu {command}", flush=True)
        done = subprocess.run([TATAMU, *command.split()], cwd=out, text=True, capture_output=True)
        if done.returncode:
            raise SystemExit(f"tatamu {command}: {done.stderr or done.stdout}")
        kept.parent.mkdir(exist_ok=True)
        kept.write_text("".join(line for line in done.stdout.splitlines(True) if not PROGRESS.match(line)))
    return kept.read_text()


def small(picture: Path, name: str, width: int) -> None:
    """Write a picture of the docs with at most that width."""
    from PIL import Image

    with Image.open(picture) as image:
        shown = image.convert("RGB")
    shown.thumbnail((width, 10 * width))
    shown.quantize(256).save(IMAGES / f"{name}.png", optimize=True)


def card(title: str, text: str, name: str, commands: list[str]) -> str:
    """Return a card of the gallery: a picture, and the commands that made it."""
    lines = "\n".join(f"tatamu {command}" for command in commands)
    return f":::{{grid-item-card}} {title}\n![{text}](images/{name}.png)\n\n```text\n{lines}\n```\n:::"


def grid(cards: list[str]) -> str:
    """Return cards side by side, or below one another on a narrow screen."""
    return "::::{grid} 1 1 2 2\n:gutter: 3\n\n" + "\n\n".join(cards) + "\n::::"


def garments(out: Path) -> None:
    """Learn and draw the folds of garments."""
    from tatamu.report import picture

    cards = []
    for name, (title, command) in GARMENTS.items():
        run(f"{command} {QUICK} --out fold-{name}", out, f"fold-{name}")
        steps = sorted((out / f"fold-{name}").glob("step-*"))
        picture(steps[-1] if steps else out / f"fold-{name}", out / f"{name}.png")
        small(out / f"{name}.png", name, 960)
        cards.append(card(title, f"{title}, with the paths of the hands.", name, [f"{command} {QUICK}"]))
    publish("gallery: garments", grid(cards))


def robots(out: Path) -> None:
    """Plan and rehearse a fold with each robot; a picture of the film of each, and the film of one."""
    from PIL import Image

    cards = []
    for robot, (fold, command) in ROBOTS.items():
        plan = f"plan {fold} --robot {robot} --out {fold}-{robot}"
        rehearse = f"rehearse {fold}-{robot} --simulator native"
        run(f"{command} --out {fold}", out, fold)
        run(plan, out, f"{fold}-{robot}")
        run(rehearse, out, f"{fold}-{robot}/rehearsal")
        film = out / f"{fold}-{robot}" / "rehearsal" / "film.gif"
        with Image.open(film) as frames:
            frames.seek(int(MIDDLE * frames.n_frames))  # type: ignore[attr-defined]
            frames.convert("RGB").save(out / f"{robot}.png")
        small(out / f"{robot}.png", f"robot-{robot}", 480)
        if robot == HERO:
            shutil.copy(film, IMAGES / "folding.gif")
        commands = [f"{command} --out {fold}", plan, rehearse]
        cards.append(card(f"`{robot}`", f"{robot} folds a towel.", f"robot-{robot}", commands))
    publish("gallery: robots", grid(cards))


def environments(out: Path) -> None:
    """Draw episodes in which the hands follow an arched curve."""
    import gymnasium
    from PIL import Image

    shown = []
    for name, moments in ENVIRONMENTS.items():
        env = gymnasium.make(f"tatamu.envs:tatamu/{name}", spacing=0.02, pixels=320, render_mode="rgb_array")
        env.reset(seed=0)
        inner = env.unwrapped
        curve = inner.task.space.middle()  # type: ignore[attr-defined]
        follow = getattr(inner, "follow", None)
        actions = list(follow(curve)) if follow else [env.action_space.sample() * 0]
        frames = [(env.step(action), env.render())[1] for action in actions]
        taken = [frames[min(int(moment * len(frames)), len(frames) - 1)] for moment in moments]
        shown += [Image.fromarray(frame).crop((40, 50, 280, 320)) for frame in taken]  # type: ignore[arg-type]
    sheet = Image.new("RGB", (sum(image.width for image in shown), shown[0].height))
    for place, image in enumerate(shown):
        sheet.paste(image, (place * image.width, 0))
    sheet.save(out / "environment.png")
    small(out / "environment.png", "environment", 1280)


def captures(out: Path) -> None:
    """Keep what commands print, and screenshots of the pages that they write."""
    from playwright.sync_api import sync_playwright

    shutil.copy("examples/measurements-towel.toml", out)
    learned = dict(ROBOTS.values())
    for fold in ("large", "small"):  # of which captures show plans and margins
        run(f"{learned[fold]} --out {fold}", out, fold)
    for name, (command, made) in CAPTURES.items():
        printed = run(command, out, made).rstrip()
        fence = "```{code-block} text\n:class: drawing\n" if "┏" in printed else "```text"  # frames must not wrap
        publish(f"capture: {name}", f"\n{fence}\n$ tatamu {command}\n{printed}\n```\n")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 1100})
        for name, path in SHOTS.items():
            page.goto((out / path).resolve().as_uri())
            page.wait_for_timeout(4000)
            page.screenshot(path=out / f"shot-{name}.png")
            small(out / f"shot-{name}.png", f"page-{name}", 1280)
        browser.close()


PARTS = {"garments": garments, "robots": robots, "environments": environments, "captures": captures}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", choices=PARTS, action="append")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for part in options.only or PARTS:
        PARTS[part](options.out)


if __name__ == "__main__":
    main()
