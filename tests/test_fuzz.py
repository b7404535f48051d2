"""Broken files of every kind end in one clean line: a short form of `make fuzz`."""

from __future__ import annotations

import sys
from pathlib import Path
from random import Random

import pytest

from tests import fuzzing

ROUNDS = 4
"""Broken files of each kind."""


@pytest.fixture(scope="module", autouse=True)
def compiled() -> None:
    fuzzing.warm()


@pytest.mark.parametrize("kind", range(len(fuzzing.KINDS)), ids=lambda k: f"{k}-{fuzzing.KINDS[k].name}")
def test_broken_files_end_in_one_clean_line(kind: int) -> None:
    seeds = range(kind, ROUNDS * len(fuzzing.KINDS), len(fuzzing.KINDS))
    wrong = {seed: found for seed in seeds if not fuzzing.acceptable(found := fuzzing.outcome(seed))}
    assert not wrong


@pytest.mark.parametrize("kind", range(len(fuzzing.KINDS)), ids=lambda k: f"{k}-{fuzzing.KINDS[k].name}")
def test_whole_files_are_read(kind: int) -> None:
    found = (fuzzing.outcome(kind + turn * len(fuzzing.KINDS), whole=True) for turn in range(12))
    assert f"{fuzzing.KINDS[kind].name}: read" in found  # one of the patterns has several pieces, which is refused


def test_a_seed_is_one_file() -> None:
    whole = bytes(range(256)) * 9
    assert fuzzing.broken(whole, Random(3)) == fuzzing.broken(whole, Random(3)) != fuzzing.broken(whole, Random(4))


def _prints(folder: Path) -> None:
    print("beside", file=sys.stderr)


def _raises(folder: Path) -> None:
    raise IndexError("index 3 is out of bounds")


def _exits(folder: Path) -> None:
    print("tatamu: a.svg: \x1b[2J", file=sys.stderr)
    sys.exit(2)


@pytest.mark.parametrize(
    ("read", "words"), [(_prints, "exit code 0 with 1 lines"), (_raises, "IndexError"), (_exits, "control characters")]
)
def test_what_is_wrong_is_found(
    read: object, words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    kind = fuzzing.Kind("a.svg", lambda folder, random: (folder / "a.svg").write_bytes(b"<svg/>"), read)  # type: ignore[arg-type]
    monkeypatch.setattr(fuzzing, "KINDS", (kind,))
    found = fuzzing.outcome(0)
    assert words in found and not fuzzing.acceptable(found)


def test_what_takes_too_long_or_too_much_is_found() -> None:
    assert not fuzzing.acceptable(fuzzing._reviewed("a.svg", 0, "", "", 2 * fuzzing.PATIENCE, 0.0))
    assert not fuzzing.acceptable(fuzzing._reviewed("a.svg", 0, "", "", 0.0, 2 * fuzzing.MAX_MEMORY))
    assert fuzzing.acceptable(fuzzing._reviewed("a.svg", 0, "", "", 1.0, 0.1))
