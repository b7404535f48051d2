"""The command `tatamu calibrate`, which finds the material of a cloth from measurements."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import typer

from tatamu.base.errors import InputError


def calibrate(
    measurements: Path = typer.Argument(
        ..., metavar="MEASUREMENTS.toml", help="File of your measurements, from `tatamu measure`."
    ),
    out: Path = typer.Option(
        ..., metavar="MATERIAL.toml", help="Material file to write. A page that shows the fits is written beside it."
    ),
    simulator: str = typer.Option(
        "native", help="Simulator to calibrate; the material is valid for this simulator only."
    ),
    spacing: float | None = typer.Option(
        None,
        help="Mesh spacing of the simulated tests in metres; default: fine enough that a finer mesh changes little.",
    ),
) -> None:
    """Find the material with which a simulator reproduces your measurements.

    The command writes two files. MATERIAL.toml is for the option `--material` of other commands. MATERIAL.html shows
    the fits, and names readings that you should repeat.

    Examples:
    `tatamu measure --template towel`

    `tatamu calibrate measurements.toml --out my-towel.toml`

    `tatamu calibrate measurements.toml --out my-towel-blender.toml --simulator blender`
    """
    from tatamu.api import calibrate as run
    from tatamu.base.files import check_targets, write_text
    from tatamu.calibration import advice_on, load_measurements
    from tatamu.calibration.page import page, shown
    from tatamu.calibration.parameters import SYMBOLS
    from tatamu.cli.progress import prepare
    from tatamu.show.progress import progress
    from tatamu.simulation.simulators import require

    if spacing is not None and not 1e-3 <= spacing <= 0.1:
        raise InputError(f"spacing: must be from 0.001 to 0.1 m, given {spacing:g} m")
    if out.suffix != ".toml":
        raise InputError(f"--out: must end with .toml, given {out}")
    picture = out.with_suffix(".html")
    check_targets([out, picture], [measurements])
    require(simulator)
    given = load_measurements(measurements)
    prepare(simulator)
    counts: Counter[str] = Counter()
    with progress("simulating the calibration tests") as report:

        def show(test: str) -> None:
            counts[test] += 1
            report(counts.total(), what=", ".join(f"{name} {count}" for name, count in counts.items()))

        found = run(given, simulator, spacing=spacing, progress=show)
    drawn = page(found)
    write_text(picture, drawn)
    found.save(out)
    for name in found.listed:
        value, spread = shown(found, name)
        print(f"  {SYMBOLS[name]:2} {name:18} {value:>24}  {spread}")
    for text in advice_on(found):
        print(text)
    print(f"{out}: material for the simulator {simulator}; the fits are in {picture}")
