"""Shows long work of commands on the console."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from threading import Event, Thread, current_thread, main_thread
from typing import TYPE_CHECKING, Self

from rich.console import Console

from tatamu.cli.program import Interrupted
from tatamu.show.progress import Report, progress

if TYPE_CHECKING:
    from tatamu.folding.task import Task
    from tatamu.study.loop import Progress

COMPILING = "compiling the simulator, once on this machine"
BAR_EVERY = 0.2
"""Time between two looks at the progress of compiling [s]."""


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


class LearningDisplay:
    """Shows a study: a bar of its trials, and as a line what is known. A Ctrl-C ends it with the best fold so far."""

    def __init__(
        self, task: Task, trials: int, baselines: int, console: Console | None = None, *, prepares: bool = True
    ) -> None:
        """Print what is going to be done.

        Args:
            task: The fold, of its first step.
            trials: Maximum number of trials of each step.
            baselines: Number of fixed trajectories of each step; 0 for none.
            console: Console for everything; None for lines on standard output, and bars on standard error.
            prepares: Whether the simulator runs in this process, and is compiled before the first trial.
        """
        self._console = console or Console()
        self._bars = console
        self._simulator = task.simulator
        self._prepared = not prepares
        self._stack = ExitStack()
        self._reports: dict[str, Report] = {}
        self._step = 0
        self._latest: Progress | None = None
        self._before = signal.getsignal(signal.SIGINT)
        steps = len(task.plan.steps)
        work = f"{trials} trials{f' in each of {steps} steps' if steps > 1 else ''}"
        work += f", {baselines} fixed trajectories" if baselines else ""
        (width, length), garment = task.garment.size, task.garment
        self.say(
            f"{garment.name} {width:g} x {length:g} m, {len(garment.vertices)} vertices, fold {task.plan.name}, "
            f"simulator {task.simulator}: {work}"
        )

    def __enter__(self) -> Self:
        """Show Ctrl-C as a line."""
        if current_thread() is main_thread():
            self._before = signal.signal(signal.SIGINT, self._interrupt)
        return self

    def __exit__(self, *_: object) -> None:
        """Close the bar, and say what was reached."""
        if current_thread() is main_thread():
            signal.signal(signal.SIGINT, self._before)
        self._end_step()

    def _interrupt(self, number: int, frame: object) -> None:
        signal.signal(signal.SIGINT, self._before)
        self.say("interrupted: writing the best fold so far; press Ctrl-C again to end at once")
        raise KeyboardInterrupt

    def show(self, now: Progress) -> None:
        """Show how far a study is. Its `progress` calls this."""
        if now.step != self._step:
            self._end_step()
            self._step = now.step
            if now.steps > 1:
                self.say(f"step {now.step} of {now.steps}{': ' if now.title else ''}{now.title}")
        if not self._prepared and now.done < now.trials:
            prepare(self._simulator, self._bars)
        self._prepared = True
        if now.stage == "first":
            advice = "searching for a shorter path (Ctrl-C keeps the best so far)"
            self.say(f"with the hand-designed curve, the cloth ends {_distance(now)}; {advice}")
        elif now.stage == "success":
            self._report("simulating the best fold in other scenarios", "simulations")(now.simulated, now.simulations)
        elif now.stage == "report":
            self._latest = now
            self._end_step()
        else:
            self._latest = now
            self._report("learning", "trials")(now.done, now.trials, best(now))

    def _report(self, title: str, unit: str) -> Report:
        """Return the function of the bar with this title; another bar is closed first."""
        if title not in self._reports:
            self._stack.close()
            self._reports = {title: self._stack.enter_context(progress(title, unit=unit, console=self._bars))}
        return self._reports[title]

    def _end_step(self) -> None:
        self._stack.close()
        self._reports = {}
        if self._latest is not None:
            self.say(f"trial {self._latest.done}/{self._latest.trials}: {best(self._latest)}")
        self._latest = None

    def say(self, text: str) -> None:
        """Print a line that stays."""
        self._console.print(text, soft_wrap=True, markup=False, highlight=False)


def best(now: Progress) -> str:
    """Return the best trial so far: its objective, and its distance from the target."""
    if now.best is None or now.best_distance is None:
        return "no fold yet" if now.done else "the first trials are running"
    return f"best C = {now.best:.4f}, {_distance(now)}"


def _distance(now: Progress) -> str:
    return f"{1e3 * (now.best_distance or 0.0):.1f} mm from the target"
