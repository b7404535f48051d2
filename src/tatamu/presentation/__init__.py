"""A toolkit for pages, charts, drawings, pictures and the replay of a fold in three dimensions.

It belongs to no domain: it depends on errors, files, scenes and rollouts, but on no learned fold, calibration or robot
plan. A package with a page collects the data and names a template that extends `base.html`:

- `page`: data and a template to one HTML file that opens offline; `base.html`, `parts.html`, `style.css`;
- `chart`: 2-D charts as plain Plotly data in the colours of the page;
- `drawing`: lines, dots, words and dimensions to scale, as SVG and as PNG; `projection` and `canvas` serve it;
- `replay`: the data of the viewer in `scripts/`; `packing` makes them small;
- `raster`, `shading`, `tube`, `image`: pictures of cloth without a browser;
- `palette`: every colour, by day and by night.

The pages themselves are in the packages of their data: `report` (a learned fold, a plan, a garment), `calibration`,
`validation`, `crosscheck`, `robots`; each has a `page.py` and a `page.html`.
"""
