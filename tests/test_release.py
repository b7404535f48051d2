"""A release has one version: that of src/tatamu/base/version.py."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import tatamu
from tatamu.simulation.source import code_of, source_digest

ROOT = Path(__file__).parent.parent
FOLDERS = ("docs", "src", "tests", "packages", "examples", "benchmarks", "studies")
STATED = re.compile(r'"tatamu": "(\d+\.\d+\.\d+)"|^version(?:: | = ")(\d+\.\d+\.\d+)', re.MULTILINE)
"""A version of tatamu in a file of its own, in CITATION.cff or in a pyproject.toml."""


def test_no_file_states_another_version() -> None:
    files = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if "_build" not in path.parts]
    texts = [path for path in files if path.suffix in (".md", ".py", ".toml", ".json")]
    stated = {
        path.relative_to(ROOT).as_posix(): match
        for path in [*texts, ROOT / "CITATION.cff", ROOT / "pyproject.toml"]
        for match in STATED.finditer(path.read_text())
    }
    assert "CITATION.cff" in stated and "docs/reference/result-folder.md" in stated
    wrong = {name: match[0] for name, match in stated.items() if (match[1] or match[2]) != tatamu.__version__}
    assert not wrong


def test_the_changelog_has_the_version_with_its_date() -> None:
    released = re.findall(r"^## \[(\d\S*)\] - (\d{4}-\d{2}-\d{2})$", (ROOT / "CHANGELOG.md").read_text(), flags=re.M)
    dated = re.search(r"^date-released: (\S+)$", (ROOT / "CITATION.cff").read_text(), flags=re.M)
    assert dated and released and released[0] == (tatamu.__version__, dated[1])


def test_words_do_not_change_the_digest_of_the_simulators() -> None:
    file = ROOT / "src" / "tatamu" / "simulation" / "native" / "air.py"
    source = file.read_text()
    reworded = re.sub(r'"""[A-Z].*?"""', '"""Other words."""', source, flags=re.DOTALL) + "\n# a comment\n"
    assert reworded != source and code_of(reworded) == code_of(source)
    assert code_of(source + "\nADDED = 1\n") != code_of(source)
    assert len(source_digest()) == 64


def test_the_constraints_name_every_package_that_is_asked_for() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    asked = [*project["dependencies"], *(each for extra in project["optional-dependencies"].values() for each in extra)]
    names = {re.split(r"[\[<>=~!]", each)[0].lower() for each in asked} - {"tatamu"}
    named = set(re.findall(r"^([\w.-]+)==\S+$", (ROOT / "constraints.txt").read_text().lower(), flags=re.M))
    assert names <= named, sorted(names - named)
