"""Simulating needs few packages; a command that needs another names the extra that installs it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from contextlib import suppress
from importlib import metadata
from pathlib import Path

from tatamu.base.extras import EXTRAS, missing
from tests.scenes import scene

ROOT = Path(__file__).parent.parent


def _needed(packages: list[str]) -> set[str]:
    """Distributions that packages need, themselves included, without extras."""
    found: set[str] = set()
    while packages:
        name = re.split(r"[\s\[\]();<>=!~]", packages.pop())[0].lower().replace("_", "-")
        if name in found:
            continue
        found.add(name)
        with suppress(metadata.PackageNotFoundError):  # of another platform
            packages += [each for each in metadata.requires(name) or [] if "extra ==" not in each]
    return found


def _optional() -> list[str]:
    """Modules that are installed here and that simulating does not need."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needed = _needed(list(project["dependencies"])) | {"tatamu"}
    return sorted(
        module
        for module, distributions in metadata.packages_distributions().items()
        if not {each.lower().replace("_", "-") for each in distributions} & needed
    )


BARE = f"""
import sys
class Nothing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {_optional()}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Nothing())
"""
"""No optional package is installed."""
COMMAND = BARE + "from tatamu.cli import main\nmain()"
DISTRIBUTIONS = {
    "PIL": "pillow",
    "skimage": "scikit-image",
    "tomli_w": "tomli-w",
    "dask": "distributed",
    "cv2": "opencv-python-headless",
}
"""Names of distributions that are not those of their modules."""


def bare(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, env=dict(os.environ), check=False
    )


def test_a_scene_is_simulated_without_any_extra(tmp_path: Path) -> None:
    scene(duration=0.05).save(tmp_path / "scene.json")
    done = bare(COMMAND, "simulate", str(tmp_path / "scene.json"), "--out", str(tmp_path / "rollout.npz"))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "rollout.npz").exists()


def test_a_missing_extra_is_named_in_one_line(tmp_path: Path) -> None:
    done = bare(f"import os; os.chdir({str(tmp_path)!r})\n" + COMMAND, "learn", "towel", "--out", "fold")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert re.fullmatch(r"tatamu: \w+: must be installed.*; run `pip install 'tatamu\[learn\]'`", line), line
    assert not list(tmp_path.iterdir())


def test_python_names_the_extra_too() -> None:
    done = bare(BARE + "import tatamu as tt\ntry:\n    tt.learn\nexcept tt.InputError as error:\n    print(error)")
    assert "pip install 'tatamu[learn]'" in done.stdout, done.stderr


def test_a_module_of_no_extra_is_another_fault() -> None:
    assert missing(ModuleNotFoundError("No module named 'nowhere'", name="nowhere")) is None
    assert missing(ModuleNotFoundError("No module named 'optuna.storages'", name="optuna.storages")) is not None


def test_the_extras_are_those_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    named = {
        extra: {re.split(r"[\[><=]", given)[0] for given in packages if not given.startswith("tatamu[")}
        for extra, packages in project["optional-dependencies"].items()
    }
    named["learn"] |= named["garments"] | named["report"]
    for extra, modules in EXTRAS.items():
        assert {DISTRIBUTIONS.get(module, module) for module in modules} <= named[extra]
    assert [re.split(r"[><=]", given)[0] for given in project["dependencies"]] == [
        *("numpy", "scipy", "numba", "pydantic", "typer", "rich")
    ]
