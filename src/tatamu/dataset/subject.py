"""The task of an episode by names and plain numbers, from which it can be made again."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tatamu.folding.task import Task, make_task
from tatamu.material import Material
from tatamu.records import OpenRecord


class Subject(OpenRecord):
    """A garment and a step of a plan."""

    garment: str
    """Name or file of the garment."""
    plan: str
    """Name or file of the fold plan."""
    step: int = 0
    """Number of the plan's step, from 0."""
    size: list[float] | None = None
    """Width and length [m]; None for the garment's own."""
    spacing: float | None = None
    """Distance between vertices [m]; None for the garment's own."""
    scale: float | None = None
    """Metres per unit of the garment's file; None if the file says so itself."""
    hands: int | None = None
    """Number of hands that fold; None for the plan's number."""
    material: dict[str, float] | str | None = None
    """Fields of the material, without disturbances, or its name or file; None for the garment's own."""
    start: list[float] | None = None
    """The cloth as it lies [m], x, y, z of each vertex; None if flat on the table."""

    def make_task(self) -> Task:
        """Return the task; the latest ones are kept.

        Raises:
            InputError: If the garment or the plan is a file that is not there, or something does not fit.
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
    """Return the fields of a material that are set, as `Material` takes them."""
    return {name: value for name, value in material.model_dump().items() if value is not None}
