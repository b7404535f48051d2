"""The folder of a rehearsal: its figures, the motion for a replay, and the fold that the robot's hands make."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tatamu.files import write_json, write_npz
from tatamu.robots.rehearsal import Rehearsal
from tatamu.rollout import Rollout
from tatamu.scene import Scene

Fold = tuple[Scene, Rollout, Rollout, np.ndarray | None]
"""The scene with the robot's hands, its rollout, the rollout with floating hands, and the wanted shape (n, 3)."""


def save(rehearsal: Rehearsal, folder: Path, fold: Fold | None = None) -> dict[str, Any]:
    """Write rehearsal.json, motion.npz and, with a fold, scene.json and rollout.npz; returns the figures."""
    figures = {**_figures(rehearsal), "fold": None if fold is None else _fold_figures(*fold)}
    if fold is not None:
        scene, with_robot, _, target = fold
        scene.save(folder / "scene.json")
        extra = {} if target is None else {"target": target}
        Rollout(with_robot.times, with_robot.positions, with_robot.faces, with_robot.info, extra).save(
            folder / "rollout.npz"
        )
    write_npz(
        folder / "motion.npz",
        {
            "times": rehearsal.times,
            "angles": rehearsal.angles,
            "joints": np.array(rehearsal.planned.plan.joints),
            "tools": rehearsal.tools,
        },
    )
    write_json(folder / "rehearsal.json", figures)
    return figures


def _figures(rehearsal: Rehearsal) -> dict[str, Any]:
    joints = rehearsal.planned.plan.joints
    return {
        "version": 1,
        "robot": rehearsal.planned.plan.robot,
        "simulated_seconds": float(rehearsal.times[-1]),
        "wall_seconds": rehearsal.wall_seconds,
        "real_time_factor": rehearsal.real_time_factor,
        "joint_error": dict(zip(joints, rehearsal.joint_error.tolist(), strict=True)),
        "tool_error": rehearsal.tool_error,
        "contacts": [
            {"links": list(contact.links), "first": contact.first, "depth": contact.depth}
            for contact in rehearsal.contacts
        ],
    }


def _fold_figures(scene: Scene, robot: Rollout, floating: Rollout, target: np.ndarray | None) -> dict[str, Any]:
    """The fold that the robot's hands make, against floating hands and the wanted shape, mean vertex distances [m]."""
    distance = np.linalg.norm(robot.positions[-1] - floating.positions[-1], axis=1)
    figures: dict[str, Any] = {
        "simulator": robot.info.get("simulator"),
        "seconds": scene.duration,
        "distance_to_floating_hands": float(distance.mean()),
        "largest_distance_to_floating_hands": float(distance.max()),
        "mean_vertex_distance": None,
        "floating_mean_vertex_distance": None,
    }
    if target is not None and target.shape == robot.positions[-1].shape:
        for name, rollout in (("mean_vertex_distance", robot), ("floating_mean_vertex_distance", floating)):
            figures[name] = float(np.linalg.norm(rollout.positions[-1] - target, axis=1).mean())
    return figures


def summary(figures: dict[str, Any]) -> list[str]:
    """The figures for people."""
    joint, error = max(figures["joint_error"].items(), key=lambda item: item[1])
    lines = [
        f"{figures['robot']}: {figures['simulated_seconds']:.1f} s rehearsed, {figures['real_time_factor']:.1f} times "
        "faster than real time",
        f"joints follow within {1e3 * error:.2f} mrad ({joint}), tools within {1e3 * figures['tool_error']:.2f} mm",
    ]
    contacts = figures["contacts"]
    lines += [
        f"warning: {' and '.join(contact['links'])} touch at {contact['first']:.2f} s, {1e3 * contact['depth']:.1f} mm"
        for contact in contacts
    ] or ["nothing touched that should not"]
    fold = figures["fold"]
    if fold is not None:
        lines.append(
            f"fold in {fold['simulator']}: {1e3 * fold['distance_to_floating_hands']:.1f} mm mean from the same fold "
            "with floating hands"
        )
    if fold is not None and fold["mean_vertex_distance"] is not None:
        lines.append(f"{1e3 * fold['mean_vertex_distance']:.1f} mm mean from the wanted shape")
    return lines
