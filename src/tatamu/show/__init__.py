"""Tools for pages, charts, drawings, pictures, and the replay of a fold in three dimensions.

These tools can be used for any kind of result. They depend on errors, files, scenes and rollouts, but not on learned
folds, calibrations or robot plans. The modules are:

- `page` makes an HTML file, which opens without a network, from data and a template that extends `base.html`.
- `chart` makes 2-D charts as plain Plotly data, in the colours of the page.
- `drawing` makes drawings to scale, as SVG and as PNG. It uses `projection` and `canvas`.
- `replay` makes the data of the replay, which `packing` compresses. The replay's viewer is in `scripts/`.
- `raster`, `shading`, `tube` and `image` make pictures of cloth without a browser.
- `palette` defines every colour in light and dark mode.

The pages themselves are in the packages whose results they show: `report` (a learned fold, a plan, a garment),
`calibration`, `validation`, `crosscheck` and `robots`. Each package has a `page.py` and a `page.html`.
"""
