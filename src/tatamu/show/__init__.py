"""Tools for pages, charts, tables, drawings, pictures, progress, and the replay of a fold.

They know scenes and rollouts, but not learned folds, calibrations or robot plans. The modules are:

- `page` makes an HTML file, which opens without a network, from data and a template that extends `base.html`.
- `quantity` has the units for readers, `table` tables for pages and the console, `material` the fields of a material.
- `progress` is the bar of every long command.
- `chart` makes 2-D charts as plain Plotly data, in the colours of the page.
- `drawing` makes drawings to scale, as SVG and as PNG. It uses `projection` and `canvas`.
- `replay` makes the data of the replay, whose viewer is in `scripts/`.
- `raster`, `shading`, `solids` and `image` make pictures of cloth without a browser.
- `palette` defines every colour in light and dark mode.

The pages are in the rooms whose results they show, each as a `page.py` and a `page.html`.
"""
