"""Draws the chart of docs/notes/search.md: the lowest objective so far over the number of simulations."""

from __future__ import annotations

from pathlib import Path

import numpy as np

WIDTH, HEIGHT = 11.0, 3.9
"""Size of the chart of all searches [in]."""
COLOURS = (*(f"C{number}" for number in range(10)), "black")
"""Colours of the searches: the ten colours of matplotlib, and black."""


def draw(courses: dict[str, dict[str, list[list[float]]]], path: Path) -> None:
    """Draw the lowest objective so far of each search, with a panel for each garment.

    The curves are medians over the random seeds.

    Args:
        courses: Lowest objectives so far of each study, by garment and search. Studies may differ in length.
        path: Path of the SVG file to write.
    """
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "tatamu", "svg.fonttype": "none"})  # always the same bytes
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(1, len(courses), figsize=(WIDTH, HEIGHT), layout="constrained")
    handles = {}
    for panel, (garment, searches) in zip(panels, courses.items(), strict=True):
        for number, (title, studies) in enumerate(searches.items()):
            if studies:
                colour = COLOURS[number % len(COLOURS)]
                count = min(map(len, studies))
                middle = np.median([study[:count] for study in studies], axis=0)
                style = {"color": colour, "linewidth": 2.4 if number == 0 else 1.2}
                (handles[title.replace("`", "")],) = panel.step(np.arange(1, count + 1), middle, where="post", **style)
        low = min((min(study) for studies in searches.values() for study in studies), default=0.0)
        panel.set(xscale="log", xlabel="simulations", title=garment, ylim=(0.98 * low, 1.35 * low))
        panel.set_xticks([1, 5, 10, 25, 50, 134], labels=["1", "5", "10", "25", "50", "134"])
        panel.minorticks_off()
        panel.grid(alpha=0.3)
    panels[0].set_ylabel("least C so far, median over seeds")
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    figure.savefig(path, metadata={"Date": None})
