"""The progress of long computations on the console."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from tatamu.cli.program import Interrupted
from tatamu.cli.progress import resumable
from tatamu.show.progress import duration, progress


def shown(monkeypatch: pytest.MonkeyPatch, *reports: tuple[float, int, int], terminal: bool = False) -> list[str]:
    """Return the lines of a computation that reports (seconds since the report before, done, total)."""
    clock = [0.0]
    monkeypatch.setattr("tatamu.show.progress.monotonic", lambda: clock[0])
    text = io.StringIO()
    console = Console(file=text, force_terminal=terminal, width=100)
    with progress("margins of towel", unit="simulations", console=console) as report:
        for seconds, done, total in reports:
            clock[0] += seconds
            report(done, total)
    return text.getvalue().splitlines()


def test_without_a_terminal_every_tenth_of_the_work_has_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = shown(monkeypatch, *((1.0, done + 1, 200) for done in range(200)))
    assert len(lines) == 1 + 1 + 10
    assert lines[6] == "margins of towel: 100 of 200 simulations, about 1 min 40 s left"
    assert lines[-1] == "margins of towel: 200 of 200 simulations"


def test_what_a_resumed_computation_has_already_does_not_count_for_the_time_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert shown(monkeypatch, (0.0, 50, 100), (40.0, 60, 100))[-1].endswith(
        "60 of 100 simulations, about 2 min 40 s left"
    )


def test_a_terminal_has_a_bar_with_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "\n".join(shown(monkeypatch, (1.0, 20, 80), terminal=True))
    assert "━" in text and "20 of 80 simulations" in text


@pytest.mark.parametrize(("seconds", "said"), [(0.2, "1 s"), (59.4, "59 s"), (70, "1 min 10 s"), (7500, "2 h 5 min")])
def test_durations_are_words(seconds: float, said: str) -> None:
    assert duration(seconds) == said


def test_an_interrupted_computation_says_what_is_kept_and_how_to_resume() -> None:
    with pytest.raises(Interrupted, match="kept in runs/x; run the same command again"), resumable("kept in runs/x"):
        raise KeyboardInterrupt
