"""The command `tatamu materials`, which lists the measured materials that come with tatamu."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import typer

from tatamu.show.quantity import factor

if TYPE_CHECKING:
    from tatamu.simulation.presets import Preset


def materials(
    name: str | None = typer.Argument(
        None, metavar="[NAME]", help="Preset to show with its sources; default: all presets in a table."
    ),
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
    console.print(
        "Presets describe other people's cloth, so they are only a first guess for yours. `tatamu materials "
        "NAME` shows the sources of a preset."
    )


COLUMNS = {
    "ρ": ("areal_density", "g/m²"),
    "Y": ("stretch_stiffness", "N/m"),
    "B": ("bending_rigidity", "µN m"),
    "l_b": ("bending_length", "cm"),
    "μ table": ("friction_table", ""),
    "t": ("thickness", "mm"),
}
"""Symbol, field and unit of each column in the table of materials."""


def _lines(presets: list[Preset]) -> Iterator[str]:
    """Yield the printed lines of the table of materials.

    Each material takes two lines, because its title must fit on a narrow terminal.
    """
    yield f"{'preset':28}" + "".join(f"{f'{head} {unit}'.strip():>8}" for head, (_, unit) in COLUMNS.items())
    for each in presets:
        values = [factor(unit) * getattr(each.material, field) for field, unit in COLUMNS.values()]
        # three digits without an exponent, which would need too much space
        row = [f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}" for value in values]
        raw = " (Blender's own numbers)" if each.material.blender is not None else ""
        yield f"{each.name:28}" + "".join(f"{cell:>8}" for cell in row)
        yield f"    {each.preset.title}{raw}"


def described(preset: Preset) -> str:
    """Return all fields of a preset (a material that comes with tatamu) as text, one field per line."""
    from tatamu.show.material import filed_units

    lines = [
        f"{preset.name}: {preset.preset.title} (a preset, so your own cloth may differ)",
        preset.preset.note,
    ]
    for name, unit in filed_units().items():
        if name in preset.material.UNSAID and name not in preset.material.model_fields_set:
            continue
        low, high = preset.spread.get(name, (None, None))
        span = "" if low is None else f", {low:g} to {high:g}"
        source = preset.source.get(name)
        value = getattr(preset.material, name)
        lines.append(f"  {name:18} {value:g} {unit}{span}" + (f"  ({source})" if source else ""))
    lines += [f"  blender.{key} = {value}" for key, value in (preset.material.blender or {}).items()]
    return "\n".join(line for line in lines if line)
