"""Makes histograms of the errors e_i, the distances between the vertices and their targets.

There are histograms of several trials of the search, as in Fig. 6 of the paper, and of the learned fold alone.
"""

from __future__ import annotations

import numpy as np

from tatamu.show.chart import Chart, Plot, axis, line, note, traces


def along(moments: list[tuple[str, np.ndarray]]) -> list[Chart]:
    """Return one histogram for each moment of the search. All histograms have the same axis of errors.

    Args:
        moments: Title of each moment, and the errors e_i of all n vertices at this moment [m], shape (n,). The moments
            are in the order of the search.
    """
    end = max(float(errors.max()) for _, errors in moments)
    width = bin_width(end)
    return [Chart(title, histogram(errors, width, end), _words(errors), "moment") for title, errors in moments]


def histogram(errors: np.ndarray, width: float, end: float | None = None) -> Plot:
    """Return a histogram of the vertices by their error e_i, the distance from their target.

    Args:
        errors: Errors e_i of the n vertices [m], shape (n,).
        width: Width of a bin [m].
        end: End of the axis [m]. If errors are larger, the axis is longer. With None, the axis ends at the largest
            error.
    """
    last = int(np.floor(max(float(errors.max()), end or 0.0) / width)) + 1
    counts = np.bincount((errors / width).astype(int), minlength=last)
    middles = (np.arange(len(counts)) + 0.5) * width * 1e3
    mean = 1e3 * errors.mean()
    beyond = 1e3 * (errors.mean() + 1.28 * errors.std())
    bars = {
        "type": "bar",
        "x": middles.round(4).tolist(),
        "y": counts.tolist(),
        "width": round(width * 1e3, 6),
        "marker": {"color": ["@plot" if middle <= beyond else "@warm" for middle in middles], "line": {"width": 0}},
        "hovertemplate": f"%{{y}} vertices<br>%{{x:.3~g}} ± {width * 500:.2g} mm<extra></extra>",
    }
    top = float(counts.max()) * 1.12
    marks = [line("x", mean), line("x", beyond)]
    side = "right" if beyond > 750.0 * last * width else "left"  # a phone has no space to the right of the plot
    words = [
        note(mean, 1, "μ", yref="paper", yanchor="bottom", xanchor="right"),
        note(beyond, 1, "μ+1.28σ", yref="paper", yanchor="bottom", xanchor=side),
    ]
    return traces(
        [bars],
        bargap=0,
        margin={"l": 52, "r": 14, "t": 26, "b": 44},
        xaxis=axis("error e<sub>i</sub> [mm]", range=[0, last * width * 1e3], showgrid=False),
        yaxis=axis("vertices", range=[0, top]),
        shapes=marks,
        annotations=words,
    )


def bin_width(largest: float) -> float:
    """Return a round bin width [m], so that a histogram has about 40 bins from zero to `largest` [m]."""
    rough = max(largest, 1e-6) / 40
    power = 10.0 ** np.floor(np.log10(rough))
    return float(power * min((1, 2, 2.5, 5, 10), key=lambda step: abs(np.log(step * power / rough))))


def _words(errors: np.ndarray) -> str:
    return f"mean {1e3 * errors.mean():.1f} mm, largest {1e3 * errors.max():.1f} mm"
