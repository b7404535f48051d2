"""The commands `tatamu observe` and `tatamu correct`.

The first command records measurements of a real fold, and infers the errors of hands, table and cloth. The second
command corrects the next fold against these errors.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tatamu.base.errors import InputError
from tatamu.cli.app import app
from tatamu.cli.cluster import SchedulerOption
from tatamu.cli.photographs import BoardOption, CornerOption, LensOption, SheetOption

if TYPE_CHECKING:
    from tatamu.after.feedback import Observation, Observed
    from tatamu.cameras.reading import FoldReading

RunArgument = Annotated[
    Path,
    typer.Argument(metavar="RUN", help="The folder of a learned fold, of a step of a plan, or of a corrected one."),
]


@app.command()
def observe(
    folder: RunArgument,
    left: Annotated[
        str | None,
        typer.Option(metavar="A,B", help="Left corner of the moved hem: too far along the fold, and to the left [mm]."),
    ] = None,
    right: Annotated[str | None, typer.Option(metavar="A,B", help="Right corner of the moved hem [mm].")] = None,
    slip: Annotated[str | None, typer.Option(metavar="A,B", help="Distance that the lower hem has moved [mm].")] = None,
    deviation: Annotated[
        float | None, typer.Option(help="Standard deviation of your numbers, in millimetres; default: 1.5.")
    ] = None,
    turned_in: Annotated[
        str | None, typer.Option(metavar="left|right|both", help="Corners that lie turned in; do not measure them.")
    ] = None,
    failed: Annotated[bool, typer.Option("--failed", help="The fold failed so that nothing can be measured.")] = False,
    form: Annotated[
        Path | None, typer.Option("--from", metavar="FILE.toml", help="Read the numbers from a form.")
    ] = None,
    photo: Annotated[
        Path | None, typer.Option(metavar="PHOTO", help="Read the numbers from a photo after the fold.")
    ] = None,
    board: BoardOption = None,
    sheet: SheetOption = None,
    before: Annotated[
        Path | None, typer.Option(metavar="PHOTO", help="Photo before the fold, with the board in the same place.")
    ] = None,
    frame: Annotated[
        str | None, typer.Option(metavar="X,Y,YAW", help="Pose of the fold's frame on the board [m, m, rad].")
    ] = None,
    lens: LensOption = None,
    corner: CornerOption = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="PICTURE", help="Draw what was read over the photo: .png or .jpg.")
    ] = None,
    template: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="Write an empty form to fill in, and end.")
    ] = None,
    scheduler: SchedulerOption = None,
) -> None:
    """Record how a real fold ended, and infer the errors of hands, table and cloth.

    At the first observation, the fold is simulated with 200 random disturbances. The simulations are kept, and an
    interrupted command can be run again to resume. If no measurement is given, earlier observations are evaluated
    again.

    Examples:
    `tatamu observe runs/towel --left 12,-3 --right 8,4 --slip 2,0`

    `tatamu observe runs/towel --right 8,4 --turned-in left`

    `tatamu observe runs/towel --failed`

    `tatamu observe runs/towel --template form.toml`

    `tatamu observe runs/towel --from form.toml`

    `tatamu observe runs/towel --photo after.jpg --before before.jpg --board board.toml --picture seen.jpg`

    `tatamu observe runs/towel/corrected-1 --left 2,0 --right 1,1`
    """
    from tatamu.after.feedback import FORM, ObservedFolder, read_template, ruler
    from tatamu.after.feedback.page import write_page
    from tatamu.base.files import write_text

    given = {"left": left, "right": right, "slip": slip}
    typed = any(each is not None for each in (*given.values(), deviation, turned_in)) or failed
    if template is not None:
        _refuse(typed or form is not None, "--template: writes an empty form; give it alone")
        if template.exists():
            raise InputError(
                f"--template: {template} exists; fill it in and give it with --from, or choose another name"
            )
        write_text(template, FORM)
        print(f"form: {template}")
        return
    _refuse(typed and form is not None, "--from: holds the numbers; give them there or as options, not both")
    seen = any(each is not None for each in (board, sheet, before, frame, lens, corner, picture))
    _refuse(
        photo is None and seen, "--photo: must be given with --board, --sheet, --before, --frame, --lens or --corner"
    )
    measured = any(each is not None for each in (*given.values(), deviation, form))
    _refuse(photo is not None and measured, "--photo: has the numbers; give it, or the numbers of a ruler")
    observation: Observation | None = None
    reading: FoldReading | None = None
    if form is not None:
        observation = read_template(form)
    elif photo is not None:
        observation, reading = _from_photo(
            folder, photo, board, sheet, before, frame, lens, corner or [], picture, failed, _sides(turned_in)
        )
    elif typed:
        pairs = {place: _pair(place, text) for place, text in given.items() if text is not None}
        sides = _sides(turned_in)
        observation = ruler(
            pairs, deviation=1e-3 * (1.5 if deviation is None else deviation), failed=failed, turned_in=sides
        )
    observed = _observed(folder, observation, scheduler)
    if reading is not None:
        from tatamu.after.feedback.explained import draw_explained
        from tatamu.cameras import pictures as look

        look.write_picture(draw_explained(observed, reading), ObservedFolder.of(folder).photos()[observed.newest])
    write_page(observed)
    for line in _lines(observed):
        print(line)


def _from_photo(
    folder: Path,
    photo: Path,
    board: Path | None,
    sheet: str | None,
    before: Path | None,
    frame: str | None,
    lens: Path | None,
    corner: list[str],
    picture: Path | None,
    failed: bool,
    turned_in: list[str],
) -> tuple[Observation, FoldReading]:
    """Read the measurements of a real fold from a photograph.

    If the user wants a picture, draw the corners that were found on the photograph.
    """
    from tatamu.after.feedback.photo import read_photo
    from tatamu.base.files import check_targets
    from tatamu.cameras import pictures as look
    from tatamu.cameras.board import PAPERS
    from tatamu.cameras.mounting import parse_pose
    from tatamu.cli.locate import parse_corners
    from tatamu.study.result import Result

    scale = board if board is not None else sheet
    if scale is None or (board is not None and sheet is not None):
        raise InputError(f"board, sheet: must give one of them, given {0 if scale is None else 2}")
    if sheet is not None and sheet not in PAPERS:
        raise InputError(f"sheet: must be {' or '.join(PAPERS)}, given {sheet!r}")
    if picture is not None:
        look.check_picture(picture, "picture")
        check_targets([picture], [path for path in (photo, before, board, lens) if path is not None])
    observation, reading = read_photo(
        Result.load(folder),
        photo,
        scale,
        before=before,
        frame=None if frame is None else parse_pose(frame, "frame"),
        lens=lens,
        corners=parse_corners(corner),
        failed=failed,
        turned_in=turned_in,
    )
    for number in observation.measured:
        print(f"{number.name}: {1e3 * number.value:+.1f} mm, σ {1e3 * number.deviation:.1f} mm")
    if picture is not None:
        look.write_picture(look.draw_reading(reading), picture)
        print(f"look at: {picture}, the corners and their targets on top of the photo")
    return observation, reading


@app.command()
def correct(
    folder: RunArgument,
    out: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Folder of the corrected fold; default: RUN/corrected-N.")
    ] = None,
    scheduler: SchedulerOption = None,
) -> None:
    """Correct the next fold: shift grasps, releases and heights against the inferred errors.

    In the name RUN/corrected-N, N is the number of observed folds. The command `tatamu plan` accepts the folder of the
    corrected fold.

    Examples:
    `tatamu correct runs/towel`

    `tatamu plan runs/towel/corrected-1 --robot hironx --out plan`
    """
    from tatamu.after.feedback import ObservedFolder, kept, write_kept
    from tatamu.after.feedback.texts import correction_lines

    place = ObservedFolder.of(folder)
    record = kept(place)
    if record is None:
        _observed(folder, None, scheduler)
        record = kept(place)
        assert record is not None, "it was written now"
    for line in correction_lines(record):
        print(line)
    if record.hands:
        print(f"corrected: {write_kept(place, record, out).folder}")


def _observed(folder: Path, observation: Observation | None, scheduler: str | None) -> Observed:
    """Infer errors from an observation of a real fold, and print the progress on the console."""
    from tatamu.after.feedback import ObservedFolder, keep
    from tatamu.after.feedback import observe as observe_fold
    from tatamu.cli.progress import prepare, resumable
    from tatamu.cluster import executor_at
    from tatamu.show.progress import progress
    from tatamu.study.result import Result

    learned = Result.load(folder)
    place = ObservedFolder.of(folder)
    if observation is None and not place.observations():
        raise InputError(f"{folder}: nothing was observed before; give --left, --right, --slip, --photo or --failed")
    with executor_at(scheduler) as executor:
        if executor is None and not place.has_draws:
            prepare(learned.simulator)
        kept = f"finished simulations are kept in {folder}"
        with resumable(kept), progress(f"scenarios of {folder.name}", unit="simulations") as report:
            observed = observe_fold(learned, observation, executor=executor, progress=report)
    keep(observed)
    return observed


def _lines(observed: Observed) -> list[str]:
    from tatamu.after.feedback import CorrectionRecord, ObservedFolder
    from tatamu.after.feedback.texts import correction_lines, posterior_lines

    folder = ObservedFolder(observed.learned.folder or Path())
    after = [] if observed.correction.is_none else [f"next: tatamu correct {folder.path}"]
    return [
        *posterior_lines(observed),
        *correction_lines(CorrectionRecord.of(observed)),
        f"posterior: {folder.posterior_file}",
        f"page: {folder.page_file}",
        *after,
    ]


def _refuse(wrong: bool, message: str) -> None:
    if wrong:
        raise InputError(message)


def _pair(name: str, text: str) -> tuple[float, float]:
    """Read two numbers in millimetres from a text such as "12,-3", and return them in metres."""
    numbers = re.fullmatch(r"\s*([-+]?\d+(?:\.\d*)?)\s*,\s*([-+]?\d+(?:\.\d*)?)\s*", text)
    if numbers is None:
        raise InputError(f"--{name}: must be two numbers in millimetres, such as 12,-3, given {text!r}")
    return 1e-3 * float(numbers[1]), 1e-3 * float(numbers[2])


def _sides(text: str | None) -> list[str]:
    if text is None:
        return []
    if text not in ("left", "right", "both"):
        raise InputError(f"--turned-in: must be left, right or both, given {text!r}")
    return ["left", "right"] if text == "both" else [text]
