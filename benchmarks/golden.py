"""What a change of structure must not change: the same commands in two trees, compared byte by byte, and timed in turn.

    python benchmarks/golden.py run TREE OUT [--only NAME ..]    what the tree makes of every case; resumes
    python benchmarks/golden.py compare OLD NEW                  where two such folders differ; exits with 1 if they do
    python benchmarks/golden.py time OLD_TREE NEW_TREE SCENE ..  the ratio of native's seconds, rollouts run in turn

TREE is a checkout; `git worktree add ../old REVISION` makes one of an earlier state. Both trees run with this Python's
libraries. Seconds, versions and pages are left out of the comparison. The scenes of `simulate` are those that the older
tree's commands wrote, so run it first and give its folder as `--scenes` to the newer.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

PASSING = {"wall_seconds", "setup_seconds", "seconds", "real_time_factor", "tatamu", "version", "made", "created"}
"""Fields that may differ from run to run or from version to version."""
COMPARED = (".json", ".npz", ".csv", ".toml")

SMALL = ["--size", "0.16x0.30", "--spacing", "0.015"]
CASES: dict[str, list[str]] = {
    "towel": ["learn", "towel", *SMALL, "--trials", "7", "--seed", "0", "--out", "OUT"],
    "parallel": ["learn", "towel", *SMALL, "--trials", "5", "--seed", "1", "--parallel", "2", "--out", "OUT"],
    "continuous": [
        *("learn", "towel", *SMALL, "--trials", "4", "--grasps", "continuous"),
        *("--hands", "1", "--sampler", "tpe", "--no-baselines", "--out", "OUT"),
    ],
    "quarters": [
        *("learn", "towel", "--size", "0.30x0.44", "--spacing", "0.02", "--fold", "quarters"),
        *("--material", "jersey", "--trials", "3", "--no-baselines", "--out", "OUT"),
    ],
    "shop": [
        *("learn", "tshirt", "--fold", "shop", "--spacing", "0.022", "--trials", "2"),
        *("--seed", "1", "--no-baselines", "--out", "OUT"),
    ],
    "leg": ["learn", "trousers", "--fold", "leg", "--spacing", "0.025", "--trials", "3", "--out", "OUT"],
    "mujoco": [
        *("learn", "towel", "--size", "0.16x0.30", "--spacing", "0.03", "--simulator", "mujoco"),
        *("--trials", "2", "--no-baselines", "--out", "OUT"),
    ],
    "reach": [
        *("learn", "towel", "--size", "0.30x0.36", "--spacing", "0.02", "--robot", "hironx"),
        *("--trials", "4", "--no-baselines", "--out", "OUT"),
    ],
    "plan": ["plan", "reach", "--robot", "hironx", "--out", "OUT"],
    "check": ["check", "leg", "--simulator", "native", "--halve", "--out", "OUT"],
    "check-all": [*("check", "mujoco", "--all", "--simulators", "native,mujoco", "--random", "1", "--out", "OUT")],
    "validate": [
        *("validate", "--only", "hang", "--only", "cantilever", "--only", "incline", "--only", "crease", "--quick"),
        *("--out", "OUT"),
    ],
    "rehearse": ["rehearse", "plan", "--simulator", "native"],
    "calibrate": ["calibrate", "EXAMPLES/measurements-towel.toml", "--out", "OUT/towel.toml"],
}
"""Commands of the command line by name; OUT is the case's folder, other names are folders of earlier cases."""

SCENES = ("towel", "quarters/step-1", "quarters/step-2", "shop/step-1", "shop/step-3", "leg", "reach")
"""Learned folds whose scene files are simulated."""

CHANGED: dict[str, tuple[dict[str, float], dict[str, float] | None, float]] = {
    "wrinkling": ({"compression": 0.05}, {"height": 0.0}, 0.002),
    "crushed": ({"bending_rigidity": 1e-6, "friction_cloth": 1.0}, {"height": 0.0}, 0.004),
    "tilted": ({"air_drag": 0.5, "poisson_ratio": 0.4}, {"height": -0.03, "tilt": 0.1}, 0.0),
    "hung": ({"areal_density": 0.3}, None, 0.0),
}
"""Name: fields of the material, the table, how much lower hands go [m]."""


def environment(tree: Path) -> dict[str, str]:
    """Return the environment in which `tatamu` is that of the tree."""
    return {**os.environ, "PYTHONPATH": str(tree.resolve() / "src"), "COLUMNS": "150", "PYTHONHASHSEED": "0"}


def run(options: argparse.Namespace) -> int:
    """Run every case that has no result yet."""
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    scenes = (options.scenes or out).resolve()
    simulated = {f"simulate-{name.replace('/', '-')}": _simulate(scenes / name / "scene.json") for name in SCENES}
    changed = {f"simulate-{name}": _simulate(scenes / "changed" / f"{name}.json") for name in CHANGED}
    cases = {**CASES, "changed": [], **simulated, **changed}
    failed = 0
    for name, arguments in cases.items():
        if (options.only and name not in options.only) or (out / f"{name}.done").exists():
            continue
        if name == "changed":
            _write_changed(scenes)
            continue
        filled = [_filled(word, name, out) for word in arguments]
        command = [sys.executable, "-m", "tatamu", *filled]
        done = subprocess.run(command, env=environment(options.tree), cwd=out, capture_output=True, text=True)
        print(f"{name}: exit code {done.returncode}", flush=True)
        if done.returncode == 0 or (name in ("check", "check-all", "validate", "rehearse") and done.returncode == 1):
            (out / f"{name}.done").write_text(str(done.returncode))
        else:
            print(done.stderr[-2000:], flush=True)
            failed += 1
    return min(failed, 1)


def _simulate(scene: Path) -> list[str]:
    return ["simulate", str(scene), "--out", "OUT/rollout.npz"]


def _write_changed(scenes: Path) -> None:
    """Scenes that no learned fold has: cloth that wrinkles, limp cloth that hands crush, an incline in moving air."""
    scene = json.loads((scenes / "towel" / "scene.json").read_text())
    for name, (material, table, lower) in CHANGED.items():
        hands = [
            {**hand, "displacements": [[x, y, z - lower] for x, y, z in hand["displacements"]]}
            for hand in scene["grippers"]
        ]
        made = {**scene, "material": {**scene["material"], **material}, "table": table, "grippers": hands}
        file = scenes / "changed" / f"{name}.json"
        file.parent.mkdir(exist_ok=True)
        file.write_text(json.dumps(made))


def _filled(word: str, name: str, out: Path) -> str:
    examples = str(Path(__file__).resolve().parent.parent / "examples")
    return word.replace("OUT", str(out / name)).replace("EXAMPLES", examples)


def digests(folder: Path) -> dict[str, str]:
    """A digest of every part of every file that is compared: per field of a JSON file, per array of an .npz."""
    found: dict[str, str] = {}
    for file in sorted(folder.rglob("*")):
        if file.suffix in COMPARED and file.is_file() and file.parent.name != "changed":
            name = str(file.relative_to(folder))
            if file.suffix == ".json":
                found |= {f"{name}:{key}": text for key, text in _leaves(json.loads(file.read_text()), "")}
            elif file.suffix == ".npz":
                with np.load(file) as arrays:
                    found |= {f"{name}:{key}": _array(key, arrays[key]) for key in arrays.files}
            else:
                found[name] = _digest(file.read_bytes())
        elif file.suffix == ".done":
            found[file.name] = file.read_text()
    return found


def _leaves(value: Any, where: str) -> list[tuple[str, str]]:
    if isinstance(value, dict):
        inner = [_leaves(item, f"{where}.{key}") for key, item in value.items() if key not in PASSING]
        return [leaf for leaves in inner for leaf in leaves]
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        inner = [_leaves(item, f"{where}.{number}") for number, item in enumerate(value)]
        return [leaf for leaves in inner for leaf in leaves]
    return [(where, _digest(json.dumps(value).encode()))]


def _array(key: str, array: np.ndarray) -> str:
    if key == "info":
        return _digest(str(_leaves(json.loads(str(array)), "")).encode())
    return _digest(str(array.dtype).encode() + np.ascontiguousarray(array).tobytes())


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


def compare(options: argparse.Namespace) -> int:
    """Print the differences."""
    old, new = digests(options.old), digests(options.new)
    different = [key for key in old.keys() | new.keys() if old.get(key) != new.get(key)]
    for key in sorted(different)[: options.most]:
        print(f"{key}: {'missing' if key not in new else 'not in the old' if key not in old else 'differs'}")
    print(f"{len(old)} parts compared, {len(different)} differ")
    return min(len(different), 1)


TIMED = """
import sys
from tatamu import Scene, simulate
scene = Scene.load(sys.argv[1])
simulate(scene.model_copy(update={"duration": 0.1}))
print(simulate(scene).info["wall_seconds"])
"""


def time(options: argparse.Namespace) -> int:
    """Rollouts of the same scenes in both trees, in turn, on one core; the ratio of their seconds."""
    for scene in options.scene:
        seconds: dict[Path, list[float]] = {options.old: [], options.new: []}
        for turn in range(options.turns):
            trees = (options.old, options.new) if turn % 2 else (options.new, options.old)
            for tree in trees:
                command = [sys.executable, "-c", TIMED, str(scene)]
                answer = subprocess.run(command, env=environment(tree), capture_output=True, text=True, check=True)
                seconds[tree].append(float(answer.stdout))
        pairs = [new / old for old, new in zip(seconds[options.old], seconds[options.new], strict=True)]
        least = min(seconds[options.new]) / min(seconds[options.old])
        print(
            f"{scene}: new / old {median(pairs):.3f} (median of {len(pairs)} pairs), {least:.3f} (least of each); "
            f"{median(seconds[options.old]):.3f} s and {median(seconds[options.new]):.3f} s",
            flush=True,
        )
    return 0


def main() -> None:
    """Parse and call."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    runs = commands.add_parser("run")
    runs.add_argument("tree", type=Path)
    runs.add_argument("out", type=Path)
    runs.add_argument("--only", nargs="+")
    runs.add_argument("--scenes", type=Path, help="folder of the older tree's run, whose scenes are simulated")
    runs.set_defaults(call=run)
    compares = commands.add_parser("compare")
    compares.add_argument("old", type=Path)
    compares.add_argument("new", type=Path)
    compares.add_argument("--most", type=int, default=40, help="lines to print at most")
    compares.set_defaults(call=compare)
    times = commands.add_parser("time")
    times.add_argument("old", type=Path)
    times.add_argument("new", type=Path)
    times.add_argument("scene", type=Path, nargs="+")
    times.add_argument("--turns", type=int, default=6)
    times.set_defaults(call=time)
    options = parser.parse_args()
    sys.exit(options.call(options))


if __name__ == "__main__":
    main()
