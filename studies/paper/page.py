"""Writes a page with the results of the repeated experiment.

The page repeats Fig. 5, Fig. 6, Table I and Table II of the paper. It also has medians over the seeds, and tests of the
paper's claims.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from studies.paper.claims import claims
from studies.paper.experiment import Choices, Study
from tatamu import __version__
from tatamu.base.files import write_json, write_text
from tatamu.report.histogram import along
from tatamu.report.measures import MEASURES, Measure
from tatamu.report.still import FINER
from tatamu.report.still import render as still
from tatamu.show.chart import Chart
from tatamu.show.image import data_uri, save_png
from tatamu.show.page import render
from tatamu.show.shading import shrink, to_pixels
from tatamu.simulation.mesh.crossings import crossings
from tatamu.study.result import Result

BLACK = "#111111"
TABLES = (
    ("Table I: weight", "mass", "mass"),
    ("Table I: structure", "tension_stiffness", "tension, compression, shear stiffness"),
    ("Table I: spring", "tension_damping", "tension, compression, shear damping"),
    ("Table II: structural rigidity", "tension_stiffness_max", "the same, most (without effect, see the docs)"),
    ("Table II: friction", "cloth_friction", "cloth friction of the table"),
    ("Table II: bending of fabric", "bending_stiffness", "bending stiffness, linear model"),
    ("Table II: bending resistance", "bending_stiffness_max", "bending stiffness, most (without effect)"),
)


def save(choices: Choices, studies: list[Study], folder: Path) -> Path:
    """Write the results as `reproduction.json`, `figure-5.png` and the page `reproduction.html`.

    Return the path of the page.
    """
    write_json(folder / "reproduction.json", data(choices, studies))
    shown = [drawn(_of(studies, name)[0].fold) for name in choices.garments]
    save_png(np.hstack([np.vstack(pair) for pair in shown]), folder / "figure-5.png")
    write_text(folder / "reproduction.html", page(choices, studies))
    return folder / "reproduction.html"


def data(choices: Choices, studies: list[Study]) -> dict[str, Any]:
    """Return the medians, claims and choices of a run as a dictionary for a JSON file. Missing values are None."""
    garments = {}
    for name in choices.garments:
        own = _of(studies, name)
        found = claims(name, studies)
        garments[name] = {
            "medians": {measure.key: _median(measure, own) for measure in MEASURES},
            "mean_vertex_distance_by_seed": [study.fold.record.best_score.mean_vertex_distance for study in own],
            "crossings_by_seed": [crossed(study) for study in own],
            "seconds_by_seed": [study.fold.record.wall_seconds for study in own],
            "moments": [{k: _finite(v) for k, v in vars(moment).items()} for moment in found.moments],
            "moved_left": found.moved_left,
            "separation_of_peaks": found.peaks,
            "slipped_less": found.slipped_less,
        }
    return {
        "version": 1,
        "tatamu": __version__,
        "simulator": choices.simulator,
        "seeds": choices.seeds,
        "trials": choices.trials,
        "garments": garments,
    }


def page(choices: Choices, studies: list[Study]) -> str:
    """Return the page with the results of the repeated experiment as HTML."""
    shown = [_of(studies, name)[0] for name in choices.garments]
    pictures = [(study, [data_uri(pixels) for pixels in drawn(study.fold)]) for study in shown]
    materials = [choices.material(name).blender or {} for name in choices.garments]
    return render(
        Path(__file__).with_name("page.html"),
        charts={study.garment: _histograms(study) for study in shown},
        title="Section VI",
        choices=choices,
        shown=shown,
        pictures=pictures,
        claims=[claims(name, studies) for name in choices.garments],
        medians=_medians(choices, studies),
        tables=[(name, [numbers.get(key, "–") for numbers in materials], today) for name, key, today in TABLES],
        chosen=_chosen(choices, shown),
    )


def _of(studies: list[Study], garment: str) -> list[Study]:
    return [study for study in studies if study.garment == garment]


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def drawn(fold: Result) -> tuple[np.ndarray, np.ndarray]:
    """Return two pictures of a garment: the target, and the learned fold with the hands' paths in black."""
    ideal = replace(
        fold.rollout, times=fold.rollout.times[:1], positions=fold.target[None], extra={"target": fold.target}
    )
    pictures = ((replace(fold, rollout=ideal), ()), (fold, (BLACK, BLACK)))
    target, result = (to_pixels(shrink(still(seen, hands, flying=False), 2 * FINER)) for seen, hands in pictures)
    return target, result


def _histograms(study: Study) -> list[Chart]:
    return [replace(chart, title=f"{study.garment}, {chart.title.lower()}") for chart in along(study.fold.moments)]


def _medians(choices: Choices, studies: list[Study]) -> list[tuple[Markup, list[str], str]]:
    """Return the rows of a table with medians of the measures of a fold.

    A row has the name of a measure, its median over the seeds for each garment, and a threshold from the literature.
    """
    rows = []
    for measure in MEASURES:
        values = [_median(measure, _of(studies, name)) for name in choices.garments]
        rows.append((Markup(measure.heading), [measure.number(value) for value in values], measure.threshold))
    counts = [np.median([crossed(study) for study in _of(studies, name)]) for name in choices.garments]
    crossing = [f"{count:g}" for count in counts]
    return [*rows, (Markup("Edges through triangles"), crossing, "0: no layer through another")]


def crossed(study: Study) -> int:
    """Return the number of edges of the mesh that pass through triangles of the mesh at the end of the learned fold."""
    return crossings(study.fold.final, study.fold.faces)


def _median(measure: Measure, studies: list[Study]) -> float | None:
    values = [measure.value(study.fold.record.best_score) for study in studies]
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _chosen(choices: Choices, shown: list[Study]) -> list[tuple[str, list[str]]]:
    """Return the choices that the paper does not state: the name of each choice, and its value for each garment."""
    tasks = [study.fold.record.task for study in shown]
    return [
        ("size (width × length)", [" × ".join(f"{side:g}" for side in task.size or []) for task in tasks]),
        ("fold", [task.fold for task in tasks]),
        ("mesh spacing", [f"{1e3 * (task.spacing or 0):g} mm" for task in tasks]),
        ("vertices", [str(len(study.fold.start)) for study in shown]),
        ("grasp candidates M", [str(task.candidates) for task in tasks]),
        ("material", [choices.materials.get(study.garment, f"paper-{study.garment}") for study in shown]),
    ]
