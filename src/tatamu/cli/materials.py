"""`tatamu materials`: measured materials to start from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from tatamu.cli.app import app

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from tatamu.presets import Preset

UNITS = {
    "areal_density": "kg/m²",
    "stretch_stiffness": "N/m",
    "poisson_ratio": "-",
    "bending_rigidity": "N m",
    "thickness": "m",
    "friction_table": "-",
    "friction_cloth": "-",
    "air_drag": "N s/m³",
}


@app.command()
def materials(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="One preset, with its sources; default: all in a table.")
    ] = None,
) -> None:
    """List the materials that come with tatamu, each with source and spread.

    A preset is somebody else's cloth: to have your own, see `tatamu measure`.

    Examples:
    `tatamu materials`

    `tatamu materials denim`

    `tatamu learn towel --material terry --out runs/terry`
    """
    from rich.console import Console

    from tatamu.presets import load_preset, names

    console = Console(soft_wrap=False, highlight=False)
    if name is None:
        console.print(_table([load_preset(each) for each in names()]))
        console.print(
            "Somebody else's cloth: a place to start. `tatamu materials NAME` says where each figure is from."
        )
    else:
        _one(console, load_preset(name))


def _table(presets: list[Preset]) -> Table:
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2))
    heads = ("preset", "what", "ρ g/m²", "Y N/m", "B µN m", "l_b cm", "μ table", "t mm")
    for number, head in enumerate(heads):
        table.add_column(head, justify="left" if number < 2 else "right", no_wrap=number != 1)
    for each in presets:
        m = each.material
        numbers = (1e3 * m.areal_density, m.stretch_stiffness, 1e6 * m.bending_rigidity, 100 * m.bending_length)
        row = [f"{number:.3g}" for number in (*numbers, m.friction_table, 1e3 * m.thickness)]
        raw = " (Blender's own numbers)" if m.blender is not None else ""
        table.add_row(each.name, each.preset.title + raw, *row)
    return table


def _one(console: Console, preset: Preset) -> None:
    from rich.table import Table

    console.print(f"{preset.name}: {preset.preset.title}. A preset: somebody else's cloth.")
    if preset.preset.note:
        console.print(preset.preset.note)
    table = Table(box=None, pad_edge=False, padding=(0, 2))
    for head in ("field", "value", "spread", "source"):
        table.add_column(head, overflow="fold", no_wrap=head != "source")
    for name, unit in UNITS.items():
        spread = preset.spread.get(name)
        span = f"{spread[0]:g} to {spread[1]:g}" if spread else ""
        table.add_row(name, f"{getattr(preset.material, name):g} {unit}", span, preset.source.get(name, ""))
    console.print(table)
    for key, value in (preset.material.blender or {}).items():
        console.print(f"  blender.{key} = {value}")
