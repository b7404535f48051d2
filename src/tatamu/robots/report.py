"""The folder of a rehearsal: its numbers, its motion, and the fold by the robot's hands."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.files import write_json, write_npz
from tatamu.folding.score import Score
from tatamu.report.measures import MEASURES
from tatamu.robots.refold import Refold
from tatamu.robots.rehearsal import Rehearsal

AS_FLOATING = 0.010
"""Limit for the mean distance between the robot's fold and the fold by floating hands, which move without a robot [m].

If the distance is below this limit, the two folds count as equal.
"""


AS_PLANNED = 0.010
"""Limit for the distance of a tool from its planned position while the tool grips the cloth [m].

Below this limit, the tool counts as following the plan.
"""


def as_planned(figures: dict[str, Any]) -> bool:
    """Return whether the tools followed the plan in a rehearsal and no links touched each other."""
    return not figures["contacts"] and figures["tool_error"] <= AS_PLANNED


def save(rehearsal: Rehearsal, folder: Path, fold: Refold | None = None) -> dict[str, Any]:
    """Write rehearsal.json and motion.npz, and return the contents of rehearsal.json.

    If a fold is given, scene.json and both simulated motions of the cloth are written, too.
    """
    joints = rehearsal.planned.plan.joints
    figures = {
        "version": 1,
        "robot": rehearsal.planned.plan.robot,
        "simulated_seconds": float(rehearsal.times[-1]),
        "wall_seconds": rehearsal.wall_seconds,
        "real_time_factor": rehearsal.real_time_factor,
        "joint_error": dict(zip(joints, rehearsal.joint_error.tolist(), strict=True)),
        "tool_error": rehearsal.tool_error,
        "contacts": [{**asdict(contact), "links": list(contact.links)} for contact in rehearsal.contacts],
        "fold": None if fold is None else _fold_figures(fold),
    }
    if fold is not None:
        fold.scene.save(folder / "scene.json")
        extra = {} if fold.target is None else {"target": fold.target}
        for name, rollout in (("rollout", fold.robot), ("floating", fold.floating)):
            replace(rollout, extra=extra).save(folder / f"{name}.npz")
    motion = {
        "times": rehearsal.times,
        "angles": rehearsal.angles,
        "joints": np.array(joints),
        "tools": rehearsal.tools,
    }
    write_npz(folder / "motion.npz", motion)
    write_json(folder / "rehearsal.json", figures)
    return figures


def _fold_figures(fold: Refold) -> dict[str, Any]:
    """Compare the fold by the robot's hands with the fold by floating hands and with the target."""
    figures: dict[str, Any] = {
        "simulator": fold.robot.info.get("simulator"),
        "halvings": fold.halvings,
        "simulated_vertices": fold.simulated_vertices,
        "seconds": fold.scene.duration,
        "distance_to_floating_hands": float(fold.apart.mean()),
        "largest_distance_to_floating_hands": float(fold.apart.max()),
        "mean_vertex_distance": None,
        "floating_mean_vertex_distance": None,
        "scores": {name: score.model_dump() for name, score in fold.scores.items()},
        "unscored": fold.unscored,
        "warnings": fold.robot.info.get("warnings", []),
    }
    if fold.target is not None:
        for name, rollout in (("mean_vertex_distance", fold.robot), ("floating_mean_vertex_distance", fold.floating)):
            figures[name] = float(np.linalg.norm(rollout.positions[-1] - fold.target, axis=1).mean())
    return figures


def summary(figures: dict[str, Any]) -> list[str]:
    """Return a rehearsal's numbers as text for the terminal."""
    joint, error = max(figures["joint_error"].items(), key=lambda item: item[1])
    lines = [
        f"{figures['robot']}: rehearsed {figures['simulated_seconds']:.1f} s of motion, "
        f"{figures['real_time_factor']:.1f} times faster than real time",
        f"joints follow the plan within {1e3 * error:.2f} mrad ({joint}), tools within "
        f"{1e3 * figures['tool_error']:.2f} mm while they hold the cloth",
    ]
    if figures["tool_error"] > AS_PLANNED:
        lines.append(f"warning: the tools deviate from the plan by more than {1e3 * AS_PLANNED:g} mm")
    lines += [
        f"warning: {' and '.join(contact['links'])} touch at {contact['first']:.2f} s and overlap by "
        f"{1e3 * contact['depth']:.1f} mm"
        for contact in figures["contacts"]
    ] or ["no forbidden contact between links"]
    return lines + ([] if figures["fold"] is None else _fold_summary(figures["fold"]))


def halved(often: int) -> str:
    """Return a text that reports how many times the edges of the mesh are halved."""
    return "halved " + {1: "once", 2: "twice"}.get(often, f"{often} times")


def _fold_summary(fold: dict[str, Any]) -> list[str]:
    mesh = f", edges {halved(fold['halvings'])}" if fold["halvings"] else ""
    lines = [
        f"in {fold['simulator']} ({fold['simulated_vertices']} vertices{mesh}), the robot's fold is on average "
        f"{1e3 * fold['distance_to_floating_hands']:.1f} mm away from the same fold by floating hands"
    ]
    if fold["mean_vertex_distance"] is not None and not fold["scores"]:
        lines.append(f"mean distance from the target: {1e3 * fold['mean_vertex_distance']:.1f} mm")
    if fold["unscored"]:
        lines.append(f"not scored: {fold['unscored']}")
    if fold["scores"]:
        lines.append(f"  {'':28}" + "".join(f"{name:>12}" for name in fold["scores"]))
        scores = [Score.model_validate(score) for score in fold["scores"].values()]
        for measure in MEASURES:
            unit = f" [{measure.unit}]" if measure.unit else ""
            cells = "".join(f"{measure.text(score):>12}" for score in scores)
            lines.append(f"  {measure.key.replace('_', ' ') + unit:28}{cells}")
    return lines + [f"warning: {warning}" for warning in fold["warnings"]]
