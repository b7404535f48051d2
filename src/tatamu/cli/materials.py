"""The command `tatamu materials`, which lists the measured materials that come with tatamu."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from tatamu.cli.app import app

if TYPE_CHECKING:
    from tatamu.simulation.presets import Preset

UNITS = {
    "areal_density": "kg/m²",
    "stretch_stiffness": "N/m",
    "stretch_stiffness_weft": "N/m",
    "shear_stiffness": "N/m",
    "poisson_ratio": "-",
    "bending_rigidity": "N m",
    "bending_rigidity_weft": "N m",
    "bending_rigidity_bias": "N m",
    "bending_hysteresis": "N",
    "bending_rigidity_initial": "N m",
    "thickness": "m",
    "friction_table": "-",
    "friction_cloth": "-",
    "air_drag": "N s/m³",
    "air_drag_normal": "N s/m³",
    "air_drag_tangential": "N s/m³",
    "air_drag_quadratic": "kg/m³",
    "air_drag_quadratic_tangential": "kg/m³",
    "air_drag_turning": "kg/m^(8/3)",
    "air_added_mass": "kg/m²",
}


@app.command()
def materials(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="One preset, with its sources; default: all in a table.")
    ] = None,
) -> None:
    """List the materials ("presets") that come with tatamu, with their sources and ranges.

    Presets describe other people's cloth. To measure your own cloth, see `tatamu measure`.

    Examples:
    `tatamu materials`

    `tatamu materials denim`

    `tatamu learn towel --material terry --out runs/terry`
    """
    from rich.console import Console

    from tatamu.simulation.material import preset_names
    from tatamu.simulation.presets import load_preset

    console = Console(soft_wrap=True, highlight=False)
    if name is not None:
        console.print(described(load_preset(name)))
        return
    for line in _lines([load_preset(each) for each in preset_names()]):
        console.print(line, markup=False)
    console.print("Presets describe other people's cloth; start from one. `tatamu materials NAME` has the sources.")


COLUMNS = ("ρ g/m²", "Y N/m", "B µN m", "l_b cm", "μ table", "t mm")
"""Headings of the columns in the table of materials.

They are areal density, stretch stiffness, bending rigidity, bending length, friction on the table, and thickness.
"""


def _lines(presets: list[Preset]) -> Iterator[str]:
    """Yield the printed lines of the table of materials.

    Each material takes two lines, because its title must fit on a narrow terminal.
    """
    yield f"{'preset':28}" + "".join(f"{head:>8}" for head in COLUMNS)
    for each in presets:
        m = each.material
        numbers = (1e3 * m.areal_density, m.stretch_stiffness, 1e6 * m.bending_rigidity, 100 * m.bending_length)
        row = [_rounded(number) for number in (*numbers, m.friction_table, 1e3 * m.thickness)]
        raw = " (Blender's own numbers)" if m.blender is not None else ""
        yield f"{each.name:28}" + "".join(f"{cell:>8}" for cell in row)
        yield f"    {each.preset.title}{raw}"


def _rounded(number: float) -> str:
    """Return a number rounded to three digits as text, without an exponent, which would need too much space."""
    return f"{number:.3g}" if abs(number) < 1000.0 else f"{number:.0f}"


def described(preset: Preset) -> str:
    """Return all fields of a preset (a material that comes with tatamu) as text, one field per line."""
    from tatamu.simulation.material import UNSAID

    lines = [f"{preset.name}: {preset.preset.title}. A preset: other people's cloth.", preset.preset.note]
    for name, unit in UNITS.items():
        if name in UNSAID and name not in preset.material.model_fields_set:
            continue
        low, high = preset.spread.get(name, (None, None))
        span = "" if low is None else f", {low:g} to {high:g}"
        source = preset.source.get(name)
        value = getattr(preset.material, name)
        lines.append(f"  {name:18} {value:g} {unit}{span}" + (f"  ({source})" if source else ""))
    lines += [f"  blender.{key} = {value}" for key, value in (preset.material.blender or {}).items()]
    return "\n".join(line for line in lines if line)
