"""The page of the paper's experiment: its Fig. 5, Fig. 6, Tables I and II, medians over seeds, and its claims."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tatamu import __version__
from tatamu.crossings import crossings
from tatamu.files import replacing, write_json, write_text
from tatamu.report import png
from tatamu.report.histogram import along
from tatamu.report.markup import table, text
from tatamu.report.shading import shrink, to_pixels
from tatamu.report.sheet import Sheet, card
from tatamu.report.still import FINER, render
from tatamu.report.verdict import MEASURES, Measure
from tatamu.reproduction.claims import Claims, claims
from tatamu.reproduction.experiment import Choices, Study
from tatamu.results import LearnedFold
from tatamu.rollout import Rollout

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
    """Write `reproduction.json`, `figure-5.png` and `reproduction.html`; returns the page."""
    write_json(folder / "reproduction.json", data(choices, studies))
    shown = [drawn(_of(studies, name)[0].fold) for name in choices.garments]
    with replacing(folder / "figure-5.png") as temporary:
        temporary.write_bytes(png.encode(np.hstack([np.vstack(pair) for pair in shown])))
    write_text(folder / "reproduction.html", page(choices, studies))
    return folder / "reproduction.html"


def data(choices: Choices, studies: list[Study]) -> dict[str, Any]:
    """Medians, claims and choices as plain data; what no seed has is null."""
    garments = {}
    for name in choices.garments:
        own, told = _of(studies, name), claims(name, studies)
        garments[name] = {
            "medians": {measure.key: _median(measure, own) for measure in MEASURES},
            "mean_vertex_distance_by_seed": [study.fold.result.best_trial.mean_vertex_distance for study in own],
            "crossings_by_seed": [crossed(study) for study in own],
            "seconds_by_seed": [study.fold.result.wall_seconds for study in own],
            "moments": [{k: _finite(v) for k, v in vars(moment).items()} for moment in told.moments],
            "moved_left": told.moved_left,
            "separation_of_peaks": told.peaks,
            "slipped_less": told.slipped_less,
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
    """The whole page."""
    names = ", ".join(choices.garments)
    count = "1 study" if choices.seeds == 1 else f"{choices.seeds} studies"
    lead = (
        f"{text(names)} in {text(choices.simulator)}: {count} of {choices.trials} trials for each garment, the first "
        "random, then a Gaussian process with expected improvement; grasps are real numbers that are floored; the best "
        "fold is that of least C."
    )
    sheet = Sheet("the paper’s experiment again", "Section VI", lead)
    shown = [_of(studies, name)[0] for name in choices.garments]
    sheet.section(
        "Fig. 5: targets and learned folds",
        f"Above the target, below the fold that seed {shown[0].seed} learned, with the hands’ paths in black.",
        card("three", "".join(_figure(study) for study in shown)),
    )
    sheet.section(
        "Fig. 6: errors along the search",
        f"How many vertices have which e<sub>i</sub> (Eq. 12), seed {shown[0].seed}: the first, random trial, then the "
        "best of 10 and of 50.",
        *(_histograms(sheet, study) for study in shown),
    )
    answers = [claims(name, studies) for name in choices.garments]
    sheet.section("What the paper claims", _ABOUT_CLAIMS, card("", _claims(answers)))
    sheet.section("Medians over seeds", "Of the best fold of each seed.", card("", _medians(choices, studies)))
    sheet.section("Tables I and II", _ABOUT_TABLES, card("", _tables(choices)))
    sheet.section("What was chosen", _ABOUT_CHOICES, card("", _choices(choices, shown)))
    return sheet.html()


_ABOUT_CLAIMS = (
    "“As the frequency value is on the left as the number of searches increases”: seeds whose mean error falls from "
    "moment to moment; the best is the best by C, which a shorter path betters too. “Two peak values”, for the towel, "
    "since the lower side slips: seeds in which the errors of what moves and of what should lie still are far apart "
    "(Ashman’s D above 2). “A trajectory that would not slip”: seeds whose best fold slips less than their first trial."
)
_ABOUT_TABLES = "The paper’s numbers under the names that Blender gives them today."
_ABOUT_CHOICES = "What the paper leaves open, each an option of the command; the reasons are in docs/reproduction.md."


def _of(studies: list[Study], garment: str) -> list[Study]:
    return [study for study in studies if study.garment == garment]


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def drawn(fold: LearnedFold) -> tuple[np.ndarray, np.ndarray]:
    """The target, and the learned fold with the hands' paths in black, as pixels."""
    told = fold.rollout
    ideal = Rollout(told.times[:1], fold.target[None], told.faces, told.info, {"target": fold.target})
    pictures = ((replace(fold, rollout=ideal), ()), (fold, (BLACK, BLACK)))
    target, result = (to_pixels(shrink(render(seen, hands, flying=False), 2 * FINER)) for seen, hands in pictures)
    return target, result


def _figure(study: Study) -> str:
    fold = study.fold
    target, result = (
        "data:image/png;base64," + base64.b64encode(png.encode(pixels)).decode() for pixels in drawn(fold)
    )
    return (
        f'<figure><img src="{target}" alt="{text(study.garment)}, target" style="width:100%">'
        f'<img src="{result}" alt="{text(study.garment)}, learned fold" style="width:100%">'
        f"<figcaption><b>{text(study.garment)}</b> {text(fold.result.task.fold)} fold</figcaption></figure>"
    )


def _histograms(sheet: Sheet, study: Study) -> str:
    drawn = along(study.fold.moments)
    charts = [sheet.chart(f"{study.garment}, {title.lower()}", chart, words, "moment") for title, words, chart in drawn]
    return card("multiples", charts)


def _claims(answers: list[Claims]) -> str:
    head = [
        "garment",
        "mean e<sub>i</sub>, slip, l<sub>x</sub>, medians",
        "moves left",
        "two peaks",
        "slips less [seeds]",
    ]
    return table(head, [_answer(answer) for answer in answers])


def _answer(answer: Claims) -> str:
    course = "; ".join(
        f"after {moment.after}: {_mm(moment.mean_vertex_distance)}, {_mm(moment.slip)}, {_mm(moment.trajectory_length)}"
        for moment in answer.moments
    )
    counts = (answer.moved_left, answer.two_peaked, answer.slipped_less)
    cells = "".join(f'<td class="number">{count} of {answer.seeds}</td>' for count in counts)
    return f'<tr><th scope="row">{text(answer.garment)}</th><td>{course}</td>{cells}</tr>'


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.1f} mm" if np.isfinite(metres) else "failed"


def _medians(choices: Choices, studies: list[Study]) -> str:
    head = ["measure", *(text(name) for name in choices.garments), "threshold"]
    return table(head, _median_rows(choices, studies))


def _median_rows(choices: Choices, studies: list[Study]) -> Iterator[str]:
    for measure in MEASURES:
        unit = f" [{measure.unit}]" if measure.unit else ""
        cells = ""
        for name in choices.garments:
            value = _median(measure, _of(studies, name))
            shown = "–" if value is None else f"{value * measure.scale:.{measure.digits}f}"
            cells += f'<td class="number">{shown}</td>'
        yield f'<tr><th scope="row">{measure.title}{unit}</th>{cells}<td>{measure.threshold}</td></tr>'
    medians = (np.median([crossed(study) for study in _of(studies, name)]) for name in choices.garments)
    cells = "".join(f'<td class="number">{count:g}</td>' for count in medians)
    yield f'<tr><th scope="row">Edges through triangles</th>{cells}<td>0: no layer through another</td></tr>'


def crossed(study: Study) -> int:
    """How many edges pass through triangles of the same cloth in the learned fold."""
    return crossings(study.fold.final, study.fold.faces)


def _median(measure: Measure, studies: list[Study]) -> float | None:
    values = [measure.value(study.fold.result.best_trial) for study in studies]
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _tables(choices: Choices) -> str:
    materials = [choices.material(name).blender or {} for name in choices.garments]
    head = ["in the paper", *(text(name) for name in choices.garments), "in Blender today"]
    body = []
    for title, key, today in TABLES:
        cells = "".join(f'<td class="number">{numbers.get(key, "–")}</td>' for numbers in materials)
        body.append(f'<tr><th scope="row">{title}</th>{cells}<td>{today}</td></tr>')
    return table(head, body)


def _choices(choices: Choices, shown: list[Study]) -> str:
    rows = [
        ("size (width × length)", [" × ".join(f"{s:g}" for s in study.fold.result.task.size or []) for study in shown]),
        ("fold", [study.fold.result.task.fold for study in shown]),
        ("mesh spacing", [f"{1e3 * (study.fold.result.task.spacing or 0):g} mm" for study in shown]),
        ("vertices", [str(len(study.fold.start)) for study in shown]),
        ("grasp candidates M", [str(study.fold.result.task.candidates) for study in shown]),
        ("material", [choices.materials.get(study.garment, f"paper-{study.garment}") for study in shown]),
    ]
    head = ["choice", *(text(name) for name in choices.garments)]
    body = [
        f'<tr><th scope="row">{name}</th>' + "".join(f"<td>{text(value)}</td>" for value in values) + "</tr>"
        for name, values in rows
    ]
    return table(head, body)
