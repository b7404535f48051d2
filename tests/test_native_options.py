"""Options: a study varies them by a record that it hands over, never by patching a module."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tatamu import InputError, Scene
from tatamu.simulation import native
from tatamu.simulation.native import ContactOptions, ElasticOptions, LimitOptions, Options, StepOptions
from tatamu.simulation.native.options import UntangleOptions
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.scene import Cloth
from tests.scenes import CLOTH, scene, sheet, together


def _two_sheets() -> Scene:
    lower, upper = sheet(0.1, 0.1, 0.02, CLOTH.thickness / 2), sheet(0.08, 0.08, 0.017, 0.01)
    return scene(cloth=together(lower, upper), duration=0.2)


def test_options_that_are_not_given_are_the_defaults() -> None:
    made = scene(duration=0.1)
    assert native.simulate(made, Options()).positions.tobytes() == native.simulate(made).positions.tobytes()


@pytest.mark.parametrize(
    "options",
    [
        Options(step=StepOptions(outer_step=5e-4)),
        Options(step=StepOptions(membrane_phase=0.5)),
        Options(elastic=ElasticOptions(angle_sum_part=1.0)),
        Options(contact=ContactOptions(restored=(1.0, 0.9))),
        Options(contact=ContactOptions(clearing_speed=0.1, recovery_speed=0.1)),
    ],
    ids=["outer step", "membrane", "curvature", "sweeps", "speeds"],
)
def test_each_kind_of_option_reaches_the_rollout(options: Options) -> None:
    made = _two_sheets()
    wave = made.cloth.vertices + np.array([0.0, 0.0, 1.0]) * 0.002 * np.sin(40 * made.cloth.vertices[:, :1])
    made = made.model_copy(
        update={"cloth": Cloth(vertices=wave, faces=made.cloth.faces, rest_vertices=made.cloth.rest)}
    )
    plain, varied = native.simulate(made), native.simulate(made, options)
    assert (plain.positions != varied.positions).any()
    assert np.abs(plain.positions - varied.positions).max() < 0.02


def test_a_wider_margin_searches_less_often_and_finds_the_same_rest() -> None:
    made = _two_sheets()
    wide = Options(contact=ContactOptions(margin_thicknesses=15.0))
    assert Simulation(made, wide).mesh.search_distance == pytest.approx(16 * CLOTH.thickness)
    plain, other = native.simulate(made).positions[-1], native.simulate(made, wide).positions[-1]
    assert np.abs(plain - other).max() < 0.1 * CLOTH.thickness


def test_the_time_step_is_what_the_options_say() -> None:
    made = scene(duration=0.1)
    steps = native.simulate(made).info["steps"]
    assert native.simulate(made, Options(step=StepOptions(outer_step=5e-4))).info["steps"] == pytest.approx(
        2 * steps, rel=0.05
    )


def test_layers_of_twice_the_thickness_take_steps_up_to_twice_as_long() -> None:
    def step(thickness: float) -> float:
        made = scene(duration=0.1)
        return Simulation(
            made.model_copy(update={"material": made.material.model_copy(update={"thickness": thickness})})
        ).sizes.outer_step

    steps = [step(thickness) for thickness in (3e-4, 1e-3, 2e-3, 3e-3)]
    assert steps[0] == steps[1] <= 1e-3 < steps[2] == steps[3] <= 2e-3


def test_numbers_become_of_the_type_that_kernels_were_compiled_for() -> None:
    options = Options(contact=ContactOptions(clearing_speed=1, pressed_searches=3.0))  # type: ignore[arg-type]
    assert type(options.contact.clearing_speed) is float
    assert type(options.contact.pressed_searches) is int


@pytest.mark.parametrize(
    ("parts", "text"),
    [
        ({"step": StepOptions(outer_step=0.0)}, "step.outer_step: must be positive"),
        ({"contact": ContactOptions(sweeps_of_many=0)}, "contact.sweeps_of_many: must be positive"),
        ({"contact": ContactOptions(hard=-0.1)}, "contact.hard: must be at least 0"),
        ({"limits": LimitOptions(farthest=np.inf)}, "limits.farthest: must be at least 0 and finite"),
        ({"untangle": UntangleOptions(step=np.nan)}, "untangle.step: must be"),
        ({"contact": ContactOptions(restored=(0.5,))}, "contact.restored: must be 1, followed by numbers above 0"),
        ({"contact": ContactOptions(restored=())}, "contact.restored: must be 1, followed by numbers above 0"),
    ],
)
def test_options_that_mean_nothing_are_refused(parts: dict, text: str) -> None:
    with pytest.raises(InputError, match=text):
        Options(**parts)


def test_options_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Options().step = StepOptions()  # type: ignore[misc]
