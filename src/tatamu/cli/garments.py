"""The command `tatamu garments`, which lists the garments that have a name, such as "towel"."""

from __future__ import annotations

from tatamu.cli.app import app


@app.command()
def garments() -> None:
    """List the garments that have a name, with their default size and fabric.

    Commands also accept a garment from a file. The file is an outline (.svg, .dxf), a mesh (.obj, .ply, .stl, .glb) or
    a garment file (.toml), which docs/reference/garment-file.md describes. `tatamu show GARMENT` draws a garment.

    Example: `tatamu garments`
    """
    from rich.console import Console

    from tatamu.garments import DESCRIPTIONS, make_garment
    from tatamu.show.table import Table, terminal
    from tatamu.simulation.material import preset_names
    from tatamu.simulation.presets import load_preset

    rows = []
    presets = {each: load_preset(each).material for each in preset_names()}
    for name, what in DESCRIPTIONS.items():
        garment = make_garment(name)
        fabric = next(each for each, material in presets.items() if material == garment.material)
        size = "{:g}x{:g}".format(*garment.size)
        rows.append((name, what, size, str(garment.layers), str(len(garment.vertices)), fabric))
    head = ("garment", "what", "width x length", "layers", "vertices", "fabric")
    Console().print(terminal(Table(head, rows)))
    print("\nYour own garment: an outline (.svg, .dxf), a mesh (.obj, .ply, .stl, .glb) or a garment file (.toml).")
