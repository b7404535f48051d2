"""The task of an episode as names and numbers, from which it can be made again."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tatamu.base.records import OpenRecord
from tatamu.folding.task import Task, make_task
from tatamu.simulation.material import Material


class Subject(OpenRecord):
    """A garment, and a step of a plan."""

    garment: str
    plan: str
    step: int = 0
    """Index of the step."""
    size: list[float] | None = None
    """[m]; None for the garment's own."""
    spacing: float | None = None
    """[m]; None for the garment's own."""
    scale: float | None = None
    """Metres per unit of the garment's file; None if the file contains its unit."""
    hands: int | None = None
    """None for the plan's number."""
    material: dict[str, float] | str | None = None
    """Its fields, name or file; None for the garment's own."""
    start: list[float] | None = None
    """x, y, z of each vertex before the fold [m]; None if the cloth lies flat."""

    def make_task(self) -> Task:
        """Return the task. The last ones are kept in memory.

        Raises:
            InputError: If a file does not exist, or the names and numbers do not fit.
        """
        return _made(self.model_dump_json(include=set(Subject.model_fields)))


@lru_cache(maxsize=4)
def _made(text: str) -> Task:
    subject = Subject.model_validate_json(text)
    material = subject.material
    task = make_task(
        subject.garment,
        fold=subject.plan,
        size=None if subject.size is None else (subject.size[0], subject.size[1]),
        material=Material(**material) if isinstance(material, dict) else material,
        spacing=subject.spacing,
        scale=subject.scale,
        hands=subject.hands,
    )
    start = None if subject.start is None else np.array(subject.start).reshape(-1, 3)
    return task.at(subject.step, start) if subject.step else task


def fields_of(material: Material) -> dict[str, float]:
    """Return the fields of a material that are set, as arguments of `Material`."""
    return {name: value for name, value in material.model_dump().items() if value is not None}
