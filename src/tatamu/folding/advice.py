"""Advice on a plan before a fold is learned: parts of the cloth that no hand carries, and plans that carry them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tatamu.base.errors import InputError
from tatamu.folding.coverage import Part, covered, other_grasp
from tatamu.folding.layout import Layout
from tatamu.folding.plan import Plan, Step
from tatamu.folding.plans import AUTO_PLAN, Proposal, known_plans, make_plan, propose
from tatamu.garments import Garment


class UncarriedWarning(UserWarning):
    """Warning that a fold moves cloth that no hand carries."""


def left_behind(garment: Garment, plan: Plan, hands: int | None = None) -> list[tuple[int, Part]]:
    """Return the parts of the cloth that a fold moves but no hand carries, each with the index of its step."""
    return [
        (number, part)
        for number, step, layout in _layouts(garment, plan)
        for part in covered(layout, step.grasp, hands or step.hands)
    ]


def _layouts(garment: Garment, plan: Plan) -> Iterator[tuple[int, Step, Layout]]:
    """Yield the index of each step, the step, and the garment before it, with all earlier folds laid flat."""
    state = garment.vertices
    for number, step in enumerate(plan.steps):
        layout = Layout(garment, state, plan.line(step, garment))
        yield number, step, layout
        state = layout.laid()


def advice(garment: Garment, plan: Plan, hands: int | None = None) -> list[str]:
    """Return a line for each part that no hand carries, then lines on what the user can do about them."""
    found = left_behind(garment, plan, hands)
    lines = [f"{_step(plan, number)}no hand carries {part.text}" for number, part in found]
    return lines + (_remedies(garment, plan, found) if found else [])


def _step(plan: Plan, number: int) -> str:
    title = plan.steps[number].title
    if len(plan.steps) == 1:
        return f"{title}: " if title else ""
    return f"step {number + 1}{', ' if title else ''}{title}: "


def _remedies(garment: Garment, plan: Plan, found: list[tuple[int, Part]]) -> list[str]:
    lines = []
    wrong = {number for number, _ in found}
    for number, _, layout in _layouts(garment, plan):
        other = other_grasp(layout) if number in wrong else None
        if other:
            shown = ", ".join(f'"{name}"' for name in other)
            lines.append(
                f"{_step(plan, number)}to carry this part, write grasp = [{shown}] in a plan file "
                "(docs/reference/fold-plan.md)"
            )
    try:
        best = choices(garment)[0]
    except InputError:
        return lines
    if not best.missed and best.plan.steps != plan.steps:
        name = AUTO_PLAN if garment.own else best.plan.name
        lines.append(
            f"give --fold {name} to carry the whole garment ({best.text}); `tatamu plans` draws this plan and others"
        )
    return lines


def choices(garment: Garment) -> list[Proposal]:
    """Return the plans for a garment, best first: the built-in ones and, for a user's garment, those of its outline."""
    if garment.own and not garment.kind:
        return propose(garment)
    plans = known_plans(garment)
    known = [Proposal(plan, tuple(left_behind(garment, plan))) for plan in plans.values()]
    if garment.own:
        known += [proposal for proposal in propose(garment) if proposal.plan.name not in plans]
    return sorted(known, key=lambda proposal: bool(proposal.missed))


def chosen(garment: Garment, names: Sequence[str]) -> list[Proposal]:
    """Return the named plans for a garment, or all of its plans if `names` is empty.

    A name is a built-in plan, the path of a plan file, or `auto` for the best plan for the garment's outline.
    """
    if not names:
        return choices(garment)
    plans = [make_plan(name, garment) for name in names]
    return [Proposal(plan, tuple(left_behind(garment, plan))) for plan in plans]
