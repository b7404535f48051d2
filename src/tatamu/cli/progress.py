"""Shows the progress of learning on the console: a bar on a terminal, otherwise a line every few seconds."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from threading import Event, Thread, current_thread, main_thread
from time import monotonic
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.progress import Progress as Bar

from tatamu.cli.app import Interrupted
from tatamu.show.progress import Report, duration, progress

if TYPE_CHECKING:
    from tatamu.folding.task import Task
    from tatamu.study.loop import Progress

COMPILING = "compiling the simulator, once on this machine"
LINE_EVERY = 5.0
"""Time between two printed lines [s], if the output is not a terminal."""
BAR_EVERY = 0.2
"""Time between two updates of the progress bar on a terminal [s]."""
STEADY = 4
"""Number of finished trials that are needed to estimate the time per trial.

One trial is not enough: the first trials run at the same time, so other trials end shortly after the first one.
"""
SILENT = 10.0
"""Longest time to wait for the first finished trial [s].

If no trial finishes within this time, the time of a single simulation is measured, and is shown to the user.
"""
WRITING = 3.0
"""Approximate time for writing a result folder and its page [s]. This time is assumed, because it is not measured."""


@contextmanager
def starting(text: str) -> Iterator[None]:
    """Print immediately what the command does first, because the imports inside the `with` block are slow."""
    console = Console()
    if not console.is_terminal:
        print(text, flush=True)
    with console.status(text) if console.is_terminal else nullcontext():
        yield


@contextmanager
def ticking(every: float, look: Callable[[], None]) -> Iterator[None]:
    """Call the function `look` every `every` seconds in a separate thread, until the `with` block ends."""
    stopped = Event()

    def tick() -> None:
        while not stopped.wait(every):
            look()

    thread = Thread(target=tick, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stopped.set()
        thread.join()


@contextmanager
def resumable(kept: str) -> Iterator[None]:
    """Say at Ctrl-C what is kept, such as "finished simulations are kept in runs/towel", and how to resume."""
    try:
        yield
    except KeyboardInterrupt:
        raise Interrupted(f"interrupted; {kept}; run the same command again to resume") from None


def prepare(simulator: str, console: Console | None = None) -> None:
    """Load or compile a simulator, and show the progress of compiling.

    Raises:
        InputError: If there is no simulator with this name.
    """
    from tatamu.simulation.simulators import named

    chosen = named(simulator)
    report: Report | None = None

    def look() -> None:
        nonlocal report
        done, total = chosen.compilation()
        if done and report is None:  # nothing is shown if the simulator need not be compiled
            report = stack.enter_context(progress(COMPILING, total, console=console))
        if done and report is not None:
            report(done, total)

    with ExitStack() as stack, ticking(BAR_EVERY, look):
        chosen.prepare()


def compiling(done: int, total: int, seconds: float) -> str:
    """Return the progress of compiling a simulator as text: `done` of `total` parts were compiled in `seconds` [s]."""
    left = duration(seconds * (total - done) / max(done, 1))
    return f"{COMPILING}, about {left} left"


@dataclass(frozen=True)
class Workload:
    """The amount of work of a study.

    For each step of the fold plan, the trials are simulated, and then the fixed trajectories for comparison.
    """

    steps: int
    trials: int
    baselines: int

    def seconds(self, step: int, pace: float, rollouts: int) -> float:
        """Return the remaining time of the study [s].

        Args:
            step: Number of the current step, from 1.
            pace: Time per simulation [s].
            rollouts: Number of simulations that remain in this step.
        """
        later = self.steps - step
        pages = later + 1 + (self.steps > 1)
        return pace * (rollouts + later * (self.trials + self.baselines)) + WRITING * pages

    def __str__(self) -> str:
        words = [f"{self.trials} trials{' in each of ' + str(self.steps) + ' steps' if self.steps > 1 else ''}"]
        words += [f"{self.baselines} fixed trajectories"] * bool(self.baselines)
        return ", ".join([*words, "and the report"])


class LearningDisplay:
    """Shows the progress of learning on the console.

    The study runs inside the `with` block of this display. The study calls `show` whenever its progress changes.
    """

    def __init__(
        self, task: Task, trials: int, baselines: int, console: Console | None = None, *, prepares: bool = True
    ) -> None:
        """Make a display, which is not shown yet.

        Args:
            task: The task to learn.
            trials: Number of trials of each step.
            baselines: Number of fixed trajectories simulated after the trials of each step.
            console: Console to print on; None for standard output.
            prepares: Whether this process simulates. If so, it loads or compiles the simulator first.
        """
        from tatamu.simulation.simulators import named

        self.task = task
        self._simulator = named(task.simulator)
        self._console = console or Console()
        self.work = Workload(len(task.plan.steps), trials, baselines)
        self._lines: Callable[[], tuple[str, int, int]] = lambda: ("preparing", 0, trials)
        self._prepared = not prepares
        self._ends = 0.0
        self._ending = False
        self._step: _Step | None = None
        self._how_long = ""
        self._before = signal.getsignal(signal.SIGINT)
        self._bar = self._make_bar() if self._console.is_terminal else None
        self._ticking = ticking(BAR_EVERY if self._bar else LINE_EVERY, self._look)
        self.say(
            f"{task.garment.name} {task.garment.size[0]:g} x {task.garment.size[1]:g} m, {len(task.garment.vertices)} "
            f"vertices, fold {task.plan.name}, simulator {task.simulator}: {self.work}"
        )

    def _make_bar(self) -> Bar:
        columns = (BarColumn(20), MofNCompleteColumn(), TextColumn("{task.description}", markup=False))
        bar = Bar(*columns, console=self._console, transient=True)
        bar.add_task("preparing", total=self.work.trials)
        return bar

    def __enter__(self) -> Self:
        if self._bar:
            self._bar.start()
        self._ticking.__enter__()
        if current_thread() is main_thread():
            self._before = signal.signal(signal.SIGINT, self._interrupt)
        return self

    def _interrupt(self, number: int, frame: object) -> None:
        """Handle Ctrl-C: end the study after the running trials.

        If the user presses Ctrl-C again, the program ends at once.
        """
        signal.signal(signal.SIGINT, self._before)
        self._ending = True
        self.say("interrupted: waiting for running trials, then finished ones are written; Ctrl-C again ends at once")
        raise KeyboardInterrupt

    def __exit__(self, *_: object) -> None:
        if current_thread() is main_thread():
            signal.signal(signal.SIGINT, self._before)
        self._ticking.__exit__(None, None, None)
        if self._step is not None:
            self._step.end()
        if self._bar:
            self._bar.stop()

    def show(self, progress: Progress) -> None:
        """Show the progress of the study of one step."""
        if self._step is None or self._step.number != progress.step:
            if self._step is not None:
                self._step.end()
            if progress.steps > 1:
                self.say(f"step {progress.step} of {progress.steps}{': ' if progress.title else ''}{progress.title}")
            self._step = _Step(self, progress.step)
        self._step.show(progress)

    def prepare(self) -> None:
        """Load or compile the simulator, if this was not done before, and show the progress."""
        if not self._prepared:
            began = monotonic()
            self._lines = lambda: self._compiling(began)
            self._simulator.prepare()
            self._prepared = True

    def forecast(self, step: int, pace: float, rollouts: int, known: bool) -> None:
        """Estimate when the study will end. The first accurate estimate is printed.

        Args:
            step: Number of the current step, from 1.
            pace: Time per simulation [s].
            rollouts: Number of simulations that remain in this step.
            known: Whether `pace` is accurate. If not, `pace` is an upper bound, because the first trials start
                together.
        """
        left = self.work.seconds(step, pace, rollouts)
        if known and self._how_long != "about":
            self.say(f"about {duration(left)} to go, a trial every {pace:.1f} s")
        self._how_long = "about" if known or self._how_long == "about" else "at most"
        self._ends = monotonic() + left

    def now(self, text: str, done: int, total: int, more: Callable[[], str] = str) -> None:
        """Show a text on the progress bar until this method is called again.

        `more` returns a further text, which changes with time. This text and, if known, the remaining time are
        appended.
        """
        self._lines = lambda: (text + more() + self._left(), done, total)
        if self._bar:
            self._look()

    def say(self, text: str) -> None:
        """Print a line that the progress bar does not overwrite."""
        self._console.print(text, soft_wrap=True, markup=False, highlight=False)

    def _compiling(self, began: float) -> tuple[str, int, int]:
        done, total = self._simulator.compilation()
        if not done:
            return "preparing", 0, 1
        return compiling(done, total, monotonic() - began), done, total

    def _left(self) -> str:
        if not self._ends or self._ending:
            return ""
        left = self._ends - monotonic()
        return f", {self._how_long} {duration(left)} left" if left > 0.0 else ", longer than expected"

    def _look(self) -> None:
        text, done, total = self._lines()
        if self._bar:
            self._bar.update(self._bar.task_ids[0], description=text, completed=done, total=total, refresh=True)
        else:
            self.say(f"{done}/{total} {text}")


class _Step:
    """Shows the progress of one step of the plan while this step is learned."""

    def __init__(self, display: LearningDisplay, number: int) -> None:
        self._display = display
        self.number = number
        self._began: float | None = None
        self._pace = 0.0
        self._first = 0
        self._latest: Progress | None = None
        self._simulation: str | None = None

    def show(self, progress: Progress) -> None:
        """Show the progress. Before the first trial, the simulator is loaded or compiled."""
        display = self._display
        self._latest = progress
        if self._began is None:
            if progress.done < progress.trials:
                display.prepare()
            self._began = monotonic()
            self._first = progress.done
        made = progress.done - self._first
        if progress.stage == "trials" and made:
            self._pace = (monotonic() - self._began) / made
        if self._pace:
            baselines = display.work.baselines
            left = {"trials": progress.trials - progress.done + baselines, "baselines": baselines}
            known = made >= min(STEADY, progress.trials - self._first)
            display.forecast(self.number, self._pace, left.get(progress.stage, 0), known)
        words = {
            "trials": "trials",
            "baselines": "fixed trajectories",
            "validation": "validating the best fold in disturbed worlds",
            "report": "writing the report",
        }
        waits = progress.stage == "trials" and not progress.done
        text = f"{words[progress.stage]}: {best(progress)}"
        display.now(text, progress.done, progress.trials, self._waiting if waits else str)

    def _waiting(self) -> str:
        """Return how long the first trials have been running, as text; empty in the first seconds.

        Later, the text also has the time of one simulation.
        """
        silent = monotonic() - (self._began or monotonic())
        if silent > SILENT and self._simulation is None:
            self._simulation = self._one_simulation()
        return f", for {duration(silent)}{self._simulation or ''}" if silent >= LINE_EVERY else ""

    def _one_simulation(self) -> str:
        """Return the time of one simulation as text; empty if this time is not known."""
        from tatamu.evaluation.pace import simulation_seconds

        seconds = simulation_seconds(self._display.task) if self.number == 1 else None
        if seconds is None:
            return ""
        many = ", and a trial in disturbed worlds has many" if self._latest and self._latest.disturbed else ""
        return f"; one simulation takes at least {duration(seconds)}{many}"

    def end(self) -> None:
        """Print the final progress of the step, as a line that stays."""
        if self._latest is not None:
            self._display.say(f"trial {self._latest.done}/{self._latest.trials}: {best(self._latest)}")


def best(progress: Progress) -> str:
    """Return a text about the best trial so far: its objective, and its distance from the target."""
    if progress.best is None or progress.best_distance is None:
        return "no fold yet" if progress.done else "the first trials are running"
    objective = "objective under disturbances" if progress.disturbed else "C"
    mesh = " on the coarse mesh" if progress.coarse else ""
    return f"best {objective}{mesh} = {progress.best:.4f}, {1000 * progress.best_distance:.1f} mm from the target"
