"""Names of files and folders: every command reads and writes whatever names the file system allows."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from collections.abc import Callable
from itertools import cycle, product
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tatamu.api import correct
from tatamu.base.files import replacing, write_text
from tatamu.cameras.lens import Lens, write_lens
from tatamu.garments import make_garment
from tatamu.study.folder import ResultFolder
from tatamu.study.store import file_store
from tests.commands import refused, tatamu
from tests.fabricated import write_fold
from tests.foreign import tshirt_svg
from tests.photos import photograph
from tests.refusals import refusal
from tests.scenes import scene
from tests.small_studies import towel
from tests.test_study_store import RECORD, finished

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows allows fewer names")
ODD = [
    "a?1",
    "x%41y",
    "a#b&c;d",
    'it\'s "so"',
    " a ",
    "Tüch 畳 🧺",
    "-dash",
    "x" * 200,
    "{a}",
    "[b]c[x]",
    "$(x)*~",
    "a\\b",
]
"""Names that URLs, shells, patterns, markup and formats read otherwise."""
NAMES = st.one_of(
    st.sampled_from(ODD),
    st.text(st.characters(exclude_characters="/\0", exclude_categories=["Cs"]), min_size=1).filter(
        lambda name: name.strip(".") and len(name.encode()) <= 200
    ),
)


@settings(max_examples=5, deadline=None)
@given(name=NAMES)
def test_a_study_lies_in_its_folder_whatever_its_name(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    root = tmp_path_factory.mktemp("studies")
    for _ in range(2):  # the second time, the study resumes
        folder = ResultFolder(root / name / "inner")
        folder.path.mkdir(parents=True, exist_ok=True)
        with file_store(folder) as store:
            number = len(store.open(RECORD))
            store.add(finished(number), towel().space)
    with file_store(folder) as store:
        assert store.open(RECORD) == [finished(0), finished(1)]
    assert [path.relative_to(root) for path in root.rglob("*") if path.is_file()] == [Path(name, "inner", "study.db")]


@settings(max_examples=30, deadline=None)
@given(name=NAMES)
def test_a_file_of_any_name_is_written(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("files")
    write_text(folder / name, "text")
    assert [path.name for path in folder.iterdir()] == [name]


def test_a_temporary_file_has_no_name_that_can_be_guessed(tmp_path: Path) -> None:
    names = set()
    for _ in range(3):
        with replacing(tmp_path / "a.txt") as temporary:
            names.add(temporary.name)
            assert temporary.exists() and temporary.stat().st_size == 0
    assert len(names) == 3 and not any(str(os.getpid()) in name for name in names)


def test_a_pipe_or_a_device_is_not_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for place in (tmp_path / "pipe", Path("/dev", f"tatamu-{os.getpid()}")):
        assert "must be the name of a file to write, given a pipe or a device" in refusal(write_text, place, "text")
    _scene(tmp_path)
    assert "given a pipe or a device" in refused("simulate", "in.json", "--out", "pipe", cwd=tmp_path)
    assert (tmp_path / "pipe").is_fifo()


@pytest.mark.parametrize(
    "words", [("measure", "--template", "towel", "--out", "LONG"), ("observe", "FOLD", "--template", "LONG")]
)
def test_a_name_that_is_too_long_is_one_line(words: tuple[str, ...], tmp_path: Path) -> None:
    write_fold(tmp_path / "fold", spacing=0.1, count=3, frames=4)
    given = [{"LONG": "x" * 300, "FOLD": "fold"}.get(word, word) for word in words]
    assert "File name too long" in refused(*given, cwd=tmp_path)


@pytest.mark.parametrize("mask", [0o022, 0o027, 0o077])
def test_the_mask_of_the_user_is_kept(mask: int, tmp_path: Path) -> None:
    before = os.umask(mask)
    try:
        write_text(tmp_path / "a.txt", "text")
    finally:
        os.umask(before)
    assert (tmp_path / "a.txt").stat().st_mode & 0o777 == 0o666 & ~mask


def _svg(folder: Path) -> None:
    shutil.move(tshirt_svg(folder), folder / "in.svg")


def _photo(folder: Path) -> None:
    photograph(folder / "in.png", (60, 90, 170), (150, 110, 75))


def _scene(folder: Path) -> None:
    scene(duration=1 / 60).save(folder / "in.json")


def _nothing(folder: Path) -> None:
    pass


COMMANDS: dict[str, tuple[Callable[[Path], None], tuple[str, ...], tuple[str, ...]]] = {
    "show": (_svg, ("show", "--spacing", "0.05", "--out", "DIR/a.html", "--", "DIR/in.svg"), ("a.html",)),
    "show into a folder": (_svg, ("show", "--spacing", "0.05", "--out", "DIR", "--", "DIR/in.svg"), ("in.png",)),
    "plans": (_svg, ("plans", "--spacing", "0.05", "--out", "DIR/a.toml", "--", "DIR/in.svg"), ("a.toml",)),
    "outline": (_photo, ("outline", "--width", "0.5", "--out", "DIR/a.svg", "--", "DIR/in.png"), ("a.svg",)),
    "board": (_nothing, ("board", "--out", "DIR/a.pdf"), ("a.pdf", "a.toml")),
    "simulate": (_scene, ("simulate", "--out", "DIR/a.npz", "--", "DIR/in.json"), ("a.npz",)),
    "measure": (_nothing, ("measure", "--template", "towel", "--out", "DIR/a.toml"), ("a.toml",)),
}


@pytest.mark.parametrize(("name", "command"), [*zip(ODD, cycle(COMMANDS), strict=False), *product(ODD[:1], COMMANDS)])
def test_a_command_reads_and_writes_in_a_folder_of_any_name(command: str, name: str, tmp_path: Path) -> None:
    make, words, written = COMMANDS[command]
    folder = tmp_path / name
    folder.mkdir()
    make(folder)
    there = {path.name for path in folder.iterdir()}
    done = tatamu(*(word.replace("DIR", name) for word in words), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in folder.iterdir()} - there >= set(written)
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("name", ODD)
def test_a_file_that_is_missing_is_named_as_given(name: str, tmp_path: Path) -> None:
    write_lens(
        Lens(width=1600, height=1200, focal=1400.0, centre=(800.0, 600.0), distortion=(0.0, 0.0)), tmp_path / name
    )
    assert (tmp_path / name).is_file()
    for words in (("show", "--", f"{name}.svg"), ("simulate", "--out", "a.npz", "--", f"{name}.json")):
        assert name.strip() in refused(*words, cwd=tmp_path)


@pytest.mark.parametrize("name", ODD)
def test_a_path_in_a_command_that_is_advised_is_the_path_for_a_shell(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_fold(Path(name), spacing=0.1, count=3, frames=4)
    said = refusal(correct, Path(name))
    folder = shlex.split(said.split("run `")[1].split("` first")[0])[2]
    assert Path(folder).is_dir() and not folder.startswith("-")


@pytest.mark.parametrize("name", ["C:\\temp\\new.svg", "sub\nshirt.svg", "sub\\a\rm.svg"])
def test_a_path_with_escapes_of_toml_is_quoted_and_the_line_says_how_to_write_it(name: str, tmp_path: Path) -> None:
    text = name.replace("\n", "\\n").replace("\r", "\\r")  # as a person writes it
    (tmp_path / "a.toml").write_text(f'[garment]\noutline = "{text}"\n')
    said = refusal(make_garment, str(tmp_path / "a.toml"))
    assert r"in paths, write / instead of \, or use single quotes" in said and said.count("a.toml") == 1


def test_a_file_with_the_name_of_a_fields_beginning_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m").write_text("no mesh")
    Path("a.toml").write_text('[garment]\nmesh = "m"\n')
    assert refusal(make_garment, "a.toml").startswith("m: mesh: ")


def test_a_file_is_named_once_whatever_its_name(tmp_path: Path) -> None:
    (tmp_path / "a  b.svg").write_text("<svg/>")
    assert refusal(make_garment, str(tmp_path / "a  b.svg")).count("b.svg") == 1


@pytest.mark.parametrize("quote", ["'", '"'])
def test_a_path_as_on_windows_is_read_or_the_line_says_how_to_write_it(quote: str, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    shutil.move(tshirt_svg(tmp_path), tmp_path / "sub" / "shirt.svg")
    (tmp_path / "a.toml").write_text(f"[garment]\nspacing = 0.05\noutline = {quote}sub\\shirt.svg{quote}\n")
    done = tatamu("show", "a.toml", cwd=tmp_path)
    if quote == "'":
        assert done.returncode == 0, done.stderr
    else:
        assert done.returncode == 2 and r"in paths, write / instead of \, or use single quotes" in done.stderr
