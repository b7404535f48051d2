"""The commands that make a learned fold again."""

from __future__ import annotations

import shlex

from tatamu.folding.task import Asked
from tatamu.results import LearnedFold
from tatamu.results.folder import SCENE


def learn(fold: LearnedFold) -> str:
    """The command that runs the same study, but for a material of the user's."""
    task = fold.result.task
    result = fold.result
    default = Asked(garment=task.garment, fold=task.fold, size=task.size, spacing=task.spacing, hands=task.hands)
    asked = result.asked or default
    folder = fold.folder.resolve()
    words = ["tatamu", "learn", asked.garment, "--out", folder.parent.name if task.step else folder.name]
    if asked.size:
        words += ["--size", "x".join(f"{side:g}" for side in asked.size)]
    if asked.scale:
        words += ["--scale", repr(asked.scale)]
    words += ["--fold", asked.fold, "--simulator", task.simulator, "--sampler", result.sampler]
    trials = str(len(result.trials)) if result.until_gain is None else "auto"
    words += ["--trials", trials, "--seed", str(result.seed)]
    if asked.hands:
        words += ["--hands", str(asked.hands)]
    if result.grasps != "integer":
        words += ["--grasps", result.grasps]
    if asked.spacing:
        words += ["--spacing", repr(asked.spacing)]
    if task.robot:
        words += ["--robot", task.robot]
    words += ["--parallel", str(result.parallel)]
    if result.coarse is None and not asked.spacing:
        words += ["--no-coarse"]
    if result.disturbances is None:
        words += ["--disturbances", "none"]
    if not result.baselines:
        words += ["--no-baselines"]
    return shlex.join(words)


def simulate(fold: LearnedFold) -> str:
    """The command that simulates the best trial alone."""
    scene = f"{fold.folder.resolve().name}/{SCENE}"
    words = ["tatamu", "simulate", scene, "--out", "again.npz", "--simulator", fold.result.task.simulator]
    return shlex.join(words)
