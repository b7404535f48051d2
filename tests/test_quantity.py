"""Values with units, and tables as data."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from tatamu.show.material import FIELDS, filed_units, properties
from tatamu.show.page import render
from tatamu.show.quantity import UNITS, Quantity, Table, shown, terminal
from tatamu.simulation.material import Material

CLOTH = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1.5e-5)


@pytest.mark.parametrize(
    ("value", "unit", "form", "text"),
    [
        (0.0125, "mm", ".1f", "12.5 mm"),
        (-0.0021, "mm", "+.1f", "−2.1 mm"),
        (0.5236, "°", ".0f", "30°"),
        (0.81, "", ".2f", "0.81"),
        (None, "mm", ".1f", "–"),
        (1.5e-5, "µN m", ".4g", "15 µN m"),
    ],
)
def test_a_value_is_shown_in_the_unit_for_readers(value: float | None, unit: str, form: str, text: str) -> None:
    assert shown(value, unit, form) == text


def test_limits_are_inclusive_and_are_said_in_the_unit_of_the_value() -> None:
    at_most = Quantity("slip", 0.02, "mm", maximum=0.02)
    assert at_most.passes is True and at_most.limit == "at most 20"
    assert Quantity("margin", 0.01, "mm", minimum=0.02).passes is False
    assert Quantity("slip", 0.02, "mm").passes is None and Quantity("slip", None, "mm", maximum=1.0).passes is None


def test_every_quantity_of_a_material_has_a_name_and_a_unit() -> None:
    assert set(FIELDS) - {"bending_length"} == set(Material.model_fields) - {"blender"}
    assert set(filed_units()) == set(FIELDS) - {"bending_length"}
    assert all(unit not in {filed for _, filed in UNITS.values()} for _, unit in FIELDS.values() if unit != "kg/m²")


def test_a_material_shows_what_has_an_effect() -> None:
    names = [each.name for each in properties(CLOTH)]
    assert "air drag" not in names and "of it in compression" not in names
    assert "bending rigidity: 15 µN m" in [f"{each.name}: {each}" for each in properties(CLOTH)]
    pressed = CLOTH.model_copy(update={"compression": 0.2, "friction_cloth": 0.0})
    assert {"of it in compression", "friction on cloth"} <= {each.name for each in properties(pressed)}


def test_a_table_is_the_same_on_a_page_and_on_the_console() -> None:
    table = Table(("name", "value"), [("<b>", Quantity("x", 0.003, "mm")), ("[red]", Quantity("y", 0.0, "mm"))])
    text = io.StringIO()
    Console(file=text, width=80).print(terminal(table))
    assert [line.split() for line in text.getvalue().splitlines()] == [
        ["name", "value"],
        ["<b>", "3", "mm"],
        ["[red]", "0", "mm"],
    ]
    assert table and not Table(("name",), [])


def test_a_page_escapes_a_table() -> None:
    nothing = Table(("name",), [])
    page = render(
        "policies/dataset/page.html",
        title="t",
        succeeded=1,
        episodes=1,
        frames=1,
        fps=1,
        seconds="1",
        facts=[],
        groups=Table(("name", "value"), [("<b>x", Quantity("x", 0.003, "mm"))]),
        measures=nothing,
        errors=nothing,
        thumbnails=[],
    )
    assert "&lt;b&gt;" in page and "<b>x" not in page
    assert '<td class="number">3 mm</td>' in page
