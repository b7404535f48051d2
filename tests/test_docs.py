"""The pages say what is true: links lead somewhere, commands and files exist, the map of rooms is the package's."""

from __future__ import annotations

import re
import runpy
from collections.abc import Iterator
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import typer
from studies.paper.__main__ import app as paper
from studies.real_cloth.__main__ import app as real_cloth

import tatamu
from tatamu.cli.app import app
from tatamu.simulation.simulators import SIMULATORS, Capabilities, capabilities
from tests import rooms
from tests.physics.__main__ import app as physics
from tests.test_structure import ORDER, SOURCE

ROOT = Path(__file__).parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
NAMES = [page.relative_to(ROOT).as_posix() for page in PAGES]
GUIDES = [name for name in NAMES if name != "CHANGELOG.md"]
"""Pages that speak of the present; a changelog speaks of what was."""
TEXT = (".md", ".py", ".toml")
CAPABILITY_PAGE = "docs/reference/simulators.md"


@cache
def read(name: str) -> str:
    return (ROOT / name).read_text()


def prose(name: str) -> str:
    """A page without its code, which is indented."""
    return re.sub(r"^    .*$", "", read(name), flags=re.M)


def anchors(page: Path) -> set[str]:
    """Where links into a page may lead, as GitHub names its headings."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(name: str) -> list[str]:
    """Everything that a page links to or shows, within the repository."""
    found = re.findall(r"\]\(([^)\s]+)\)", prose(name))
    return [target for target in found if not target.startswith(("http:", "https:"))]


@pytest.mark.parametrize("name", NAMES)
def test_every_link_and_picture_of_a_page_is_there(name: str) -> None:
    for target in links(name):
        path, _, anchor = target.partition("#")
        page = (ROOT / name).parent / path if path else ROOT / name
        assert page.exists(), f"{name} links to {target}"
        assert not anchor or anchor in anchors(page), f"{name} links to {target}: no such heading"


def targets(name: str) -> set[str]:
    """The files that a page links to, from the repository's root."""
    paths = ((ROOT / name).parent / target.partition("#")[0] for target in links(name))
    return {path.resolve().relative_to(ROOT).as_posix() for path in paths}


def test_the_index_has_every_page_and_every_picture_is_shown() -> None:
    assert "docs/index.md" in targets("README.md")
    pages = {name for name in NAMES if name.startswith("docs/")}
    assert not pages - targets("docs/index.md") - {"docs/index.md"}
    pictures = {picture.relative_to(ROOT).as_posix() for picture in (ROOT / "docs" / "images").iterdir()}
    assert not pictures - set().union(*map(targets, NAMES))


@pytest.mark.parametrize("repository", [None, "https://example.org/tatamu"])
def test_no_link_of_the_readme_leads_nowhere_on_pypi(repository: str | None) -> None:
    shown = runpy.run_path(str(ROOT / "setup.py"))["readme"](read("README.md"), repository)
    assert len(shown) > 1000 and all(
        target.startswith(("https:", "#")) for target in re.findall(r"\]\(([^)]+)\)", shown)
    )


@cache
def commands() -> dict[str, set[str]]:
    """Every command of the command line with its options."""
    group = typer.main.get_command(app)
    return {
        name: options_of(command)
        for name, command in group.commands.items()  # type: ignore[attr-defined]
        if not command.hidden
    }


def options_of(command: Any) -> set[str]:
    return {
        option
        for p in command.params
        if not getattr(p, "hidden", False)
        for option in [*p.opts, *p.secondary_opts]
        if option.startswith("-")
    }


def uses(name: str) -> Iterator[tuple[str, list[str]]]:
    """Each `tatamu COMMAND ..` that a page names, with the options that follow on its line or in its backticks."""
    code = [line for line in read(name).splitlines() if line.startswith("    ")]
    inline = re.findall(r"`([^`]*)`", prose(name).replace("\n", " "))
    for text in code + inline:
        for command, rest in re.findall(r"(?:^|(?<!from)(?<!import)\s|/)tatamu ([a-z]+)\b([^#]*)", text):
            yield command, re.findall(r"(?<!\S)\[?(--[a-z][a-z-]*)", rest)


@pytest.mark.parametrize("name", GUIDES)
def test_every_command_and_option_of_a_page_exists(name: str) -> None:
    known = commands()
    for command, options in uses(name):
        assert command in known, f"{name}: there is no `tatamu {command}`"
        missing = set(options) - known[command] - {"--help"}
        assert not missing, f"{name}: `tatamu {command}` has no {missing}"


@pytest.mark.parametrize(
    "name", [name for name in GUIDES if name.startswith(("README", "docs/guide", "docs/reference"))]
)
def test_every_option_named_alone_belongs_to_some_command(name: str) -> None:
    ours = set().union(*commands().values()) | {"--help", "--version"}
    for text in re.findall(r"`(--[^`]*)`", prose(name)):
        assert set(re.findall(r"(?<!\S)--[a-z][a-z-]*", text)) <= ours | options_of_programs(), f"{name}: {text}"


@cache
def options_of_programs() -> frozenset[str]:
    files = [path for folder in ("benchmarks", "studies") for path in (ROOT / folder).rglob("*.py")]
    given = {option for file in files for option in re.findall(r'add_argument\(\s*"(--[a-z-]+)"', file.read_text())}
    typed = {option for app in (paper, physics, real_cloth) for option in options_of(typer.main.get_command(app))}
    return frozenset(given | typed)


def test_the_reference_of_the_command_line_has_every_command_and_option() -> None:
    rows = dict(re.findall(r"^\| `tatamu ([a-z]+)(.*)$", read("docs/reference/command-line.md"), flags=re.M))
    assert set(rows) == set(commands())
    for command, options in commands().items():
        named = set(re.findall(r"--[a-z][a-z-]*", rows[command]))
        opposite = {option for option in options if option.startswith("--no-")}
        apart = {"--help", "-h"} | {option.replace("--no-", "--") for option in opposite}
        assert named == options - apart, f"tatamu {command}"


def test_the_reference_of_python_has_every_public_name_once() -> None:
    named = re.findall(r"^\| `(\w+)` \| \S", read("docs/reference/python.md"), flags=re.M)
    assert sorted(named) == sorted(tatamu.__all__)


def test_every_name_of_tatamu_that_a_page_uses_is_public() -> None:
    for name in GUIDES:
        used = set(re.findall(r"\btt\.(\w+)", read(name)))
        assert used <= set(tatamu.__all__), f"{name}: {used - set(tatamu.__all__)}"


@pytest.mark.parametrize("name", GUIDES)
def test_every_make_target_of_a_page_exists(name: str) -> None:
    targets = set(re.findall(r"^([a-z-]+):", read("Makefile"), flags=re.M))
    code = [line.strip() for line in read(name).splitlines() if line.startswith("    ")]
    inline = re.findall(r"`([^`]*)`", prose(name).replace("\n", " "))
    named = {target for text in code + inline for target in re.findall(r"^make ([a-z][a-z-]*)", text)}
    assert named <= targets, f"{name}: make {named - targets}"


@pytest.mark.parametrize("name", GUIDES)
def test_every_file_of_the_repository_that_a_page_names_exists(name: str) -> None:
    named = set(re.findall(r"\b(?:src/tatamu|tests|benchmarks|studies|examples)/[\w/-]+\.\w+", read(name)))
    missing = sorted(path for path in named if not (ROOT / path).exists())
    assert not missing, f"{name} names {missing}"


def test_every_page_that_the_code_names_exists() -> None:
    folders = [ROOT / part for part in ("src", "tests", "benchmarks", "studies", "examples")]
    files = [path for folder in folders for path in folder.rglob("*") if path.suffix in TEXT]
    missing = [
        f"{file.relative_to(ROOT)}: {page}"
        for file in [*files, ROOT / "Makefile", ROOT / "pyproject.toml"]
        for page in re.findall(r"\bdocs/[\w/-]+\.md\b", file.read_text())
        if not (ROOT / page).exists()
    ]
    assert not missing


def test_the_architecture_page_has_the_table_of_rooms() -> None:
    assert rooms.table() in read("docs/architecture.md"), "run: python -m tests.rooms --write-docs"


def test_every_room_has_its_place_in_the_order() -> None:
    found = {path.stem for path in SOURCE.iterdir() if not path.name.startswith("_") and path.suffix in ("", ".py")}
    assert found == set(ORDER)


def test_the_capabilities_on_the_page_are_those_that_simulators_state() -> None:
    head, *rows = re.findall(
        r"^\| (`?\w+`?) \| .+? \| (.+) \|$", read(CAPABILITY_PAGE).partition("## Cap")[2], flags=re.M
    )
    assert re.findall(r"`(\w+)`", head[1]) == list(SIMULATORS)
    assert [name.strip("`") for name, _ in rows] == [field.name for field in fields(Capabilities)]
    shown = {True: "yes", False: "no", None: "-"}
    for name, cells in rows:
        stated = [getattr(capabilities(simulator), name.strip("`")) for simulator in SIMULATORS]
        assert cells.split(" | ") == [shown.get(value) or f"{value:g}" for value in stated], name
