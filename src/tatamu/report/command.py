"""The commands that make a learned fold again."""

from __future__ import annotations

import math
import shlex

from tatamu.report.fold import LearnedFold


def learn(fold: LearnedFold) -> str:
    """The command that runs the same study; the recorded one if the study knows it."""
    if fold.result.command:
        return fold.result.command
    task, result = fold.result.task, fold.result
    folder = fold.folder.resolve()
    words = ["tatamu", "learn", task.garment, "--out", folder.parent.name if task.step else folder.name]
    if task.size:
        words += ["--size", "x".join(f"{side:g}" for side in task.size)]
    words += ["--fold", task.fold, "--simulator", task.simulator, "--sampler", result.sampler]
    words += ["--trials", str(len(result.trials)), "--seed", str(result.seed)]
    if task.hands != 2:
        words += ["--hands", str(task.hands)]
    if result.grasps != "integer":
        words += ["--grasps", result.grasps]
    if task.spacing and not math.isclose(task.spacing, task.material.bending_length / 2):
        words += ["--spacing", repr(task.spacing)]
    if task.robot:
        words += ["--robot", task.robot]
    if result.parallel != 1:
        words += ["--parallel", str(result.parallel)]
    if not result.baselines:
        words += ["--no-baselines"]
    return shlex.join(words)


def simulate(fold: LearnedFold) -> str:
    """The command that simulates the best trial alone."""
    scene = f"{fold.folder.resolve().name}/scene.json"
    words = ["tatamu", "simulate", scene, "--out", "again.npz", "--simulator", fold.result.task.simulator]
    return shlex.join(words)
