"""The tables of the page: measures with thresholds, parameters, grasps, timing, material."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tatamu.report.markup import rows, table, text
from tatamu.report.verdict import MEASURES, Measure, grade
from tatamu.results import LearnedFold, Scores


def measures(fold: LearnedFold) -> str:
    """Every measure of the learned fold beside the fixed trajectories and the field's thresholds."""
    others = fold.result.baselines
    head = ["measure", "learned", *(text(other.label) for other in others), "threshold", "source"]
    columns: list[Scores] = [fold.result.best_trial, *others]
    return _compared(head, columns)


def compared(columns: Sequence[tuple[str, Scores]]) -> str:
    """Every measure of several folds, each under its name, beside the field's thresholds."""
    names, scores = [text(name) for name, _ in columns], [score for _, score in columns]
    return _compared(["measure", *names, "threshold", "source"], scores)


def _compared(head: list[str], columns: list[Scores]) -> str:
    return table(head, [_verdicts(columns), *(_measure(measure, columns) for measure in MEASURES)], "measures")


def _verdicts(columns: list[Scores]) -> str:
    words = [grade(scores.mean_vertex_distance) for scores in columns]
    cells = "".join(f'<td><span class="pill {_slug(word)}">{word}</span></td>' for word in words)
    name = '<th scope="row">Verdict<small>by mean vertex distance</small></th>'
    return f"<tr>{name}{cells}<td></td><td></td></tr>"


def _slug(word: str) -> str:
    return word.replace(" ", "-")


def _measure(measure: Measure, columns: list[Scores]) -> str:
    unit = f" [{measure.unit}]" if measure.unit else ""
    name = f'<th scope="row">{measure.title}{unit}<small>{measure.meaning}</small></th>'
    cells = "".join(_cell(measure, scores, first=number == 0) for number, scores in enumerate(columns))
    return f"<tr>{name}{cells}<td>{measure.threshold}</td><td>{measure.source}</td></tr>"


def _cell(measure: Measure, scores: Scores, *, first: bool) -> str:
    mark = {
        None: "",
        True: ' <span class="yes" title="meets the threshold">✓</span>',
        False: ' <span class="no" title="misses the threshold">✗</span>',
    }[measure.passes(scores)]
    return f'<td class="number{" learned" if first else ""}">{measure.text(scores)}{mark}</td>'


def parameters(fold: LearnedFold) -> str:
    """What the search chose, Eq. 9."""
    given = fold.result.best_trial.parameters
    lengths = [
        (f"{name[0]}{'₁₂'[int(name[1]) - 1]} of P{'₁₂'[int(name[1]) - 1]}", f"{1e3 * given[name]:.1f} mm")
        for name in ("x1", "z1", "x2", "z2")
        if name in given
    ]
    count = fold.result.task.candidates
    of = f" of {count}" if count else ""
    # The paper searches g1 and g2 as continuous numbers and takes their floor.
    grasps = [
        (f"g{'₁₂'[k]}, {hand} grasp", f"{int(given[name])}{of}")
        for k, (name, hand) in enumerate((("g1", "left"), ("g2", "right")))
        if name in given
    ]
    return rows([*lengths, *grasps])


def control_points(fold: LearnedFold) -> str:
    """Grasp and control points of each hand."""
    arms = fold.manipulation.arms
    most = max(len(arm.control_points) for arm in arms)
    head = ["hand", "grasp", *(f"P{number} (x, y, z) [mm]" for number in range(most))]
    body = []
    for arm in arms:
        held = len(arm.grasp.patch)
        grasp = f"vertex {arm.grasp.vertex}" + (f", holds {held}" if held else "")
        places = "".join(f'<td class="number">{_place(point)}</td>' for point in arm.control_points)
        body.append(f'<tr><th scope="row">{text(arm.name)}</th><td>{grasp}</td>{places}</tr>')
    return table(head, body)


def _place(point: np.ndarray) -> str:
    return ", ".join(f"{1e3 * value:.0f}".replace("-", "−") for value in point)


def timing(fold: LearnedFold) -> str:
    """When the hands close, go, arrive, open."""
    known = {
        "closes": "hands close",
        "starts": "hands start",
        "arrives": "hands arrive",
        "opens": "hands open",
        "ends": "rollout ends",
        "top_speed": "top speed",
    }
    given = fold.manipulation.timing_values
    return rows(
        (word, f"{given[name]:.3g} {'m/s' if name == 'top_speed' else 's'}")
        for name, word in known.items()
        if name in given
    )


def material(fold: LearnedFold) -> str:
    """The cloth's material in SI units."""
    cloth = fold.result.task.material
    return rows(
        [
            ("areal density", f"{1e3 * cloth.areal_density:.4g} g/m²"),
            ("stretch stiffness", f"{cloth.stretch_stiffness:.4g} N/m"),
            *([("of it in compression", f"{cloth.compression:.3g}")] if cloth.compression < 1.0 else []),
            ("Poisson ratio", f"{cloth.poisson_ratio:.3g}"),
            ("bending rigidity", f"{1e6 * cloth.bending_rigidity:.4g} µN m"),
            ("bending length", f"{1e3 * cloth.bending_length:.3g} mm"),
            ("thickness", f"{1e3 * cloth.thickness:.3g} mm"),
            ("friction on table", f"{cloth.friction_table:.3g}"),
            ("friction on cloth", f"{cloth.friction_cloth:.3g}"),
            *([("air drag", f"{cloth.air_drag:.3g} N s/m³")] if cloth.air_drag else []),
        ]
    )


def task(fold: LearnedFold) -> str:
    """What was simulated, with what, for how long."""
    chosen, info, result = fold.result.task, fold.rollout.info, fold.result
    size = " × ".join(f"{side:g}" for side in chosen.size) + " m" if chosen.size else ""
    simulated = info.get("wall_seconds")
    pairs = [
        ("garment", chosen.garment),
        ("size", size),
        ("fold", chosen.fold),
        ("vertices", str(len(fold.start))),
        ("spacing", f"{1e3 * chosen.spacing:.3g} mm" if chosen.spacing else ""),
        ("simulator", f"{chosen.simulator} {info.get('version', '')}".strip()),
        ("one rollout", f"{simulated:.2f} s" if isinstance(simulated, int | float) else ""),
        ("sampler, seed", f"{result.sampler}, {result.seed}"),
        ("trials", f"{len(result.trials)}, best no. {result.best}"),
        ("whole search", f"{result.wall_seconds:.3g} s" if result.wall_seconds is not None else ""),
    ]
    return rows([pair for pair in pairs if pair[1]])


def warnings(fold: LearnedFold) -> str:
    """What the simulator warned of, if anything."""
    said = fold.rollout.info.get("warnings") or []
    items = "".join(f"<li>{text(str(warning))}</li>" for warning in said)
    return f'<ul class="warnings" aria-label="Warnings of the simulator">{items}</ul>' if items else ""
