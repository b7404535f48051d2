"""Makes the tables that compare the searches, and the data of the chart of all searches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median

import numpy as np
from studies.search.courses import Course, Studies
from studies.search.methods import FEW, MANY, METHODS, OURS, PAIR
from studies.search.settings import GARMENTS

COUNTS = (1, 5, 10, 25, 50, 134)
"""Numbers of trials after which the searches are compared."""


def table(studies: Studies, garment: str, seeds: int) -> list[dict[str, str]]:
    """Return a table with a row for each search method: the median and the worst result over all random seeds."""
    rows = []
    for name, method in METHODS.items():
        counts = {count: studies.courses(garment, name, count, seeds) for count in COUNTS}
        if not counts[1]:
            continue
        row = {"search": method.title, "seeds": _seeds(counts)}
        for count, courses in counts.items():
            row[f"C {count}"] = _spread([course.best(count)[0] for course in courses], ".3f")
        for count in (10, 50, 134):
            row[f"mm {count}"] = _spread([1e3 * course.best(count)[1] for course in counts[count]], ".1f")
        rows.append(row)
    return rows


def _seeds(counts: Mapping[int, Sequence[Course]]) -> str:
    first, last = len(counts[FEW]), len(counts[MANY])
    return str(first) if last in (0, first) else f"{first}, {last} to {MANY}"


def _spread(values: Sequence[float], digits: str) -> str:
    """Return the median and the largest of some values as text."""
    if not values:
        return "-"
    if len(values) == 1:
        return format(values[0], digits)
    return f"{median(values):{digits}}, {max(values):{digits}}"


def pair_table(studies: Studies, seeds: int) -> list[dict[str, str]]:
    """Return a table that compares tatamu's Gaussian process with Optuna's GPSampler.

    The table uses the random seeds for which studies of both exist.
    """
    rows = []
    for garment in GARMENTS:
        both = [
            (ours, theirs)
            for seed in range(seeds)
            for ours, theirs in [tuple(studies.course(garment, name, seed) for name in PAIR)]
            if ours is not None and theirs is not None
        ]
        if not both:
            continue
        row = {"garment": garment, "seeds": str(len(both))}
        for count in (10, 25, 50):
            for title, place in (("gp", 0), ("GPSampler", 1)):
                row[f"{title} {count}"] = _spread([pair[place].best(count)[0] for pair in both], ".4f")
        rows.append(row)
    return rows


def answers(studies: Studies, seeds: int) -> list[dict[str, str]]:
    """Return a table that shows after how many trials tatamu's search is as good as other searches.

    The reference is the lowest objective that another search has found after `FEW` trials, as a median over random
    seeds. The table has the number of trials after which the median of tatamu's search reaches this reference.
    """
    rows = []
    for garment in GARMENTS:
        for ours in OURS:
            row = {"garment": garment, "search": METHODS[ours].title}
            for name, wanted in (("random", 10), ("plain", 25)):
                pairs = [
                    (studies.course(garment, ours, seed), studies.course(garment, name, seed)) for seed in range(seeds)
                ]
                both = [(own, theirs) for own, theirs in pairs if own is not None and theirs is not None]
                if both:
                    bar = median(theirs.best(FEW)[0] for _, theirs in both)
                    medians = {n: median(own.best(n)[0] for own, _ in both) for n in range(1, FEW + 1)}
                    trials = next((str(n) for n, value in medians.items() if value <= bar), f"not in {FEW}")
                    row[f"C of {name} after {FEW} (seeds)"] = f"{bar:.3f} ({len(both)})"
                    row[f"reached after (wanted: {wanted})"] = trials
            rows.append(row)
    return [row for row in rows if len(row) > 2]


def courses_of(studies: Studies, seeds: int) -> dict[str, dict[str, list[list[float]]]]:
    """Return the data of the chart: the lowest objective so far at every trial of every study.

    The data are grouped by garment and by the title of the search method.
    """
    return {
        garment: {
            method.title: [
                np.minimum.accumulate(course.objectives).tolist()
                for course in studies.courses(garment, name, FEW, seeds)
            ]
            for name, method in METHODS.items()
        }
        for garment in GARMENTS
    }
