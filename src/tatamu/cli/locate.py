"""The command `tatamu locate`, which finds a garment on the table in a photograph."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tatamu.base.errors import InputError
from tatamu.base.size import parse_size
from tatamu.cli.photographs import (
    BoardOption,
    CornerOption,
    JoinOption,
    LensOption,
    PictureOption,
    SheetOption,
    scale_of,
)

if TYPE_CHECKING:
    import numpy as np


def locate(
    photo: Path = typer.Argument(..., metavar="PHOTO", help="Photo of the whole cloth, with the board beside it."),
    board: BoardOption = None,
    sheet: SheetOption = None,
    run: Path | None = typer.Option(
        None, metavar="RUN", help="Folder of a learned fold; the fold's garment is compared with the cloth."
    ),
    garment: str = typer.Option(
        "towel",
        help="Garment to compare with the cloth if --run is not given: a name such as towel, or the file of a garment.",
    ),
    size: str | None = typer.Option(
        None, metavar="WIDTHxLENGTH", help="Size of the garment in metres; the cloth must have this size."
    ),
    board_pose: str | None = typer.Option(
        None, metavar="X,Y,YAW", help="Pose of the board in the robot's base frame [m, m, rad]."
    ),
    touch: str | None = typer.Option(
        None,
        metavar="'X,Y X,Y X,Y'",
        help="Points where the robot touched the board's marks A, B and C, each as x,y or x,y,z in the robot's base "
        "frame [m].",
    ),
    lens: LensOption = None,
    corner: CornerOption = None,
    join: JoinOption = False,
    picture: PictureOption = None,
    from_above: Path | None = typer.Option(
        None, metavar="PICTURE", help="Picture to write: the table seen from above, .png or .jpg."
    ),
    out: Path | None = typer.Option(
        None, metavar="LOCATED.json", help="File to write: pose, size, corners and outline."
    ),
) -> None:
    """Find the pose, size and outline of a garment on the table from a photo.

    The command also prints the value for the option `--place` of `tatamu plan`.

    Examples:
    `tatamu locate towel.jpg --board board.toml --picture found.jpg`

    `tatamu locate towel.jpg --board board.toml --run runs/towel --board-pose 0.35,-0.30,1.571`

    `tatamu locate shirt.jpg --sheet a4 --garment tshirt --corner hem-left=812,1640`
    """
    from tatamu.base.files import check_targets, write_json
    from tatamu.cameras import pictures as look
    from tatamu.cameras.locate import locate as find
    from tatamu.cameras.pose import parse_pose, parse_touched

    scale = scale_of(board, sheet)
    for option, path in {"picture": picture, "from-above": from_above}.items():
        if path is not None:
            look.check_picture(path, option)
    if out is not None and out.suffix.lower() != ".json":
        raise InputError(f"--out: must be a .json file, given {out}")
    sources = [path for path in (photo, board, lens) if path is not None]
    check_targets([path for path in (picture, from_above, out) if path is not None], sources)
    found = find(
        photo,
        scale,
        run=run,
        garment=garment,
        size=None if size is None else parse_size(size),
        board_pose=None if board_pose is None else parse_pose(board_pose, "board-pose"),
        touched=None if touch is None else parse_touched(touch),
        lens=lens,
        corners=parse_corners(corner or []),
        join=join,
    )
    for line in found.lines():
        print(line)
    if out is not None:
        write_json(out, found.describe())
        print(f"file: {out}")
    if picture is not None:
        look.write_picture(look.draw_located(found), picture)
        print(f"check the outline and the corners in {picture}")
    if from_above is not None:
        look.write_picture(look.from_above(found.photograph, found.fit.place(found.fit.shape.points)), from_above)
        print(f"check the view from above in {from_above}")


def parse_corners(texts: Sequence[str]) -> dict[str, np.ndarray]:
    """Read the pixels of a garment's corners from texts NAME=X,Y.

    The result has the pixel of each corner, shape (2,), by the name of the corner.

    Raises:
        InputError: If a text has another form, or a name is given twice.
    """
    import numpy as np  # imported here, so `tatamu --help` is quick

    found: dict[str, np.ndarray] = {}
    for text in texts:
        name, _, pixel = text.partition("=")
        try:
            place = np.array([float(part) for part in pixel.split(",")])
        except ValueError:
            place = np.empty(0)
        if not name or place.shape != (2,) or not (np.abs(place) < 1e6).all():
            raise InputError(f"--corner: must be NAME=X,Y in pixels, such as bottom-left=812,1640, given {text!r}")
        if name in found:
            raise InputError(f"--corner: must not name the same corner twice, given {name} twice")
        found[name] = place
    return found
