"""The commands `tatamu observe` and `tatamu correct`: where a real fold ended, and the correction of the next one."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tatamu.base.errors import InputError
from tatamu.base.files import check_targets, in_shell, write_text
from tatamu.cli.locate import parse_corners
from tatamu.cli.options import SchedulerOption
from tatamu.cli.photographs import BoardOption, CornerOption, LensOption, PictureOption, SheetOption, scale_of

if TYPE_CHECKING:
    from tatamu.after.feedback import Feedback, MeasuredFold
    from tatamu.cameras.reading import FoldReading
    from tatamu.study.result import Result

RunArgument = Annotated[
    Path,
    typer.Argument(metavar="RUN", help="Folder of a learned fold, of a step of a plan, or of a corrected fold."),
]


def observe(
    folder: RunArgument,
    left: str | None = typer.Option(
        None,
        metavar="A,B",
        help="Deviation of the left corner of the moved hem from its target [mm]: along the fold (too far is positive) "
        "and across it (left is positive).",
    ),
    right: str | None = typer.Option(
        None,
        metavar="A,B",
        help="Deviation of the right corner of the moved hem from its target [mm], measured as for --left.",
    ),
    slip: str | None = typer.Option(
        None, metavar="A,B", help="How far the lower hem has slipped [mm]: along the fold and across it."
    ),
    deviation: float | None = typer.Option(None, help="Standard deviation of the measurements [mm]; default: 1.5."),
    turned_in: str | None = typer.Option(
        None, metavar="left|right|both", help="Corners that are turned in; leave out their numbers."
    ),
    failed: bool = typer.Option(False, "--failed", help="The fold failed, so nothing can be measured."),
    form: Path | None = typer.Option(
        None, "--from", metavar="FILE.toml", help="Filled-in form; --template writes an empty one."
    ),
    photo: Path | None = typer.Option(
        None, metavar="PHOTO", help="Photo after the fold, from which the numbers are read."
    ),
    board: BoardOption = None,
    sheet: SheetOption = None,
    before: Path | None = typer.Option(
        None, metavar="PHOTO", help="Photo before the fold, with the board in the same place."
    ),
    frame: str | None = typer.Option(
        None, metavar="X,Y,YAW", help="Pose of the fold's frame on the board [m, m, rad]."
    ),
    lens: LensOption = None,
    corner: CornerOption = None,
    picture: PictureOption = None,
    template: Path | None = typer.Option(
        None, metavar="FILE.toml", help="Write an empty form to fill in, and do nothing else."
    ),
    scheduler: SchedulerOption = None,
) -> None:
    """Record how a real fold ended, and infer the errors of hands, table and cloth.

    The first call simulates 100 scenarios, which takes minutes; these simulations are kept, so later calls take
    seconds. To resume an interrupted command, repeat it. Without numbers, the folds that were measured before are
    evaluated again.

    Examples:
    `tatamu observe runs/towel --left 12,-3 --right 8,4 --slip 2,0`

    `tatamu observe runs/towel --right 8,4 --turned-in left`

    `tatamu observe runs/towel --failed`

    `tatamu observe runs/towel --template form.toml`

    `tatamu observe runs/towel --from form.toml`

    `tatamu observe runs/towel --photo after.jpg --before before.jpg --board board.toml --picture seen.jpg`

    `tatamu observe runs/towel/corrected-1 --left 2,0 --right 1,1`
    """
    from tatamu.after.feedback import FORM, FeedbackFolder, read_template, ruler, size_of
    from tatamu.after.feedback.texts import correction_lines, posterior_lines
    from tatamu.api import observe as observe_fold
    from tatamu.study.result import Result

    given = {"left": left, "right": right, "slip": slip}
    typed = any(each is not None for each in (*given.values(), deviation, turned_in)) or failed
    if template is not None:
        empty = "--template: must be given without measured numbers, because it only writes an empty form"
        _refuse(typed or form is not None, empty)
        other = (
            f"--template: {template} already exists; fill in this form and read it with --from, or choose another name"
        )
        _refuse(template.exists(), other)
        write_text(template, FORM)
        print(f"form: {template}")
        return
    seen = any(each is not None for each in (board, sheet, before, frame, lens, corner, picture))
    numbers = any(each is not None for each in (*given.values(), deviation, form))
    twice = "--from: must be given without other numbers, because the form contains the numbers"
    _refuse(typed and form is not None, twice)
    need = "because --board, --sheet, --before, --frame, --lens, --corner and --picture need a photo"
    _refuse(photo is None and seen, f"--photo: must be given, {need}")
    ruler_too = "--photo: must be given without other numbers, because the numbers are read from the photo"
    _refuse(photo is not None and numbers, ruler_too)
    learned = Result.load(folder)
    size = size_of(learned.task.fold)
    measured: MeasuredFold | None = None
    reading: FoldReading | None = None
    if form is not None:
        measured = read_template(form, size)
    elif photo is not None:
        from tatamu.after.feedback.photo import read_photo
        from tatamu.cameras import pictures as look
        from tatamu.cameras.pose import parse_pose

        sides = _sides(turned_in)
        scale = scale_of(board, sheet)
        if picture is not None:
            look.check_picture(picture, "picture")
            check_targets([picture], [path for path in (photo, before, board, lens) if path is not None])
        measured, reading = read_photo(
            learned,
            photo,
            scale,
            before=before,
            frame=None if frame is None else parse_pose(frame, "frame"),
            lens=lens,
            corners=parse_corners(corner or []),
            failed=failed,
            turned_in=sides,
        )
        for number in measured.measured:
            print(f"{number.name}: {1e3 * number.value:+.1f} mm, σ {1e3 * number.deviation:.1f} mm")
        if picture is not None:
            look.write_picture(look.draw_reading(reading), picture)
            print(f"check the corners and their targets in {picture}")
    elif typed:
        pairs = {place: _pair(place, text) for place, text in given.items() if text is not None}
        sides = _sides(turned_in)
        measured = ruler(pairs, size, label="--{}", unit="mm", deviation=deviation, failed=failed, turned_in=sides)
    found = _feedback(learned, measured is None, scheduler, partial(observe_fold, measured=measured, reading=reading))
    for line in (*posterior_lines(found), *correction_lines(found.correction)):
        print(line)
    files = FeedbackFolder(found.learned.folder or Path())
    print(f"posterior: {files.posterior_file}")
    print(f"page: {files.page_file}")
    if not found.correction.is_none:
        print(f"next: run `tatamu correct {in_shell(files.path)}`")


def correct(
    folder: RunArgument,
    out: Path | None = typer.Option(
        None, metavar="OUT", help="Folder of the corrected fold; default: RUN/corrected-N."
    ),
    scheduler: SchedulerOption = None,
) -> None:
    """Correct the next fold: shift grasps, releases and heights to make up for the inferred errors.

    N is the number of measured folds. `tatamu plan` accepts the folder of the corrected fold. If there is nothing to
    correct, nothing is written.

    Examples:
    `tatamu correct runs/towel`

    `tatamu plan runs/towel/corrected-1 --robot hironx --out plan`
    """
    from tatamu.after.feedback import FeedbackFolder
    from tatamu.after.feedback import observe as observe_fold
    from tatamu.after.feedback.texts import correction_lines
    from tatamu.api import correct as correct_fold
    from tatamu.study.result import Result

    found = _feedback(Result.load(folder), True, scheduler, observe_fold)
    for line in correction_lines(found.correction):
        print(line)
    if found.correction.is_none:
        print("written: nothing")
    else:
        path = out or FeedbackFolder.of(folder).corrected(found.correction.folds)
        print(f"corrected: {correct_fold(found, out=path).folder}")


def _feedback(learned: Result, again: bool, scheduler: str | None, run: Callable[..., Feedback]) -> Feedback:
    """Infer the errors of the set-up, with a bar on the console; `again` without a new measured fold."""
    from tatamu.after.feedback import FeedbackFolder
    from tatamu.cli.progress import prepare, resumable
    from tatamu.cluster import executor_at
    from tatamu.show.progress import progress

    path = learned.folder or Path()
    place = FeedbackFolder.of(path)
    if again:
        place.require_measured(path)
    with executor_at(scheduler) as executor:
        if executor is None and not place.has_draws:
            prepare(learned.simulator)
        kept = f"finished simulations are kept in {place.path}"
        with resumable(kept), progress(f"scenarios of {path.name}", unit="simulations") as report:
            return run(learned, executor=executor, progress=report)


def _refuse(wrong: bool, message: str) -> None:
    if wrong:
        raise InputError(message)


def _pair(name: str, text: str) -> tuple[float, float]:
    """Return the two numbers of a text such as "12,-3"."""
    numbers = re.fullmatch(r"\s*([-+]?\d+(?:\.\d*)?)\s*,\s*([-+]?\d+(?:\.\d*)?)\s*", text)
    if numbers is None:
        raise InputError(f"--{name}: must be two numbers in millimetres, such as 12,-3, given {text!r}")
    return float(numbers[1]), float(numbers[2])


def _sides(text: str | None) -> list[str]:
    if text is None:
        return []
    if text not in ("left", "right", "both"):
        raise InputError(f"--turned-in: must be left, right or both, given {text!r}")
    return ["left", "right"] if text == "both" else [text]
