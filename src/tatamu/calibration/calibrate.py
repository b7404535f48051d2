"""Calibration: measurements in, the parameters of one simulator out (paper, section IV).

Areal density is mass over area. Stretch stiffness and bending rigidity are matched in turn, each in its own tests with
the other as it stands, until both stay; where sag and loop both tell bending, it is the mean of what each says alone,
each weighing as much as its readings tell; friction does not touch those tests, and is searched once they are done, and
compression, which needs all the others, last. Every parameter is an effective one: with it this simulator, on such a
mesh, gives the readings.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tatamu.calibration.friction import Sliding, Slope, threshold
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.match import Match
from tatamu.calibration.measurements import Measurements
from tatamu.calibration.push import Push
from tatamu.calibration.readings import Reading, readings_of
from tatamu.calibration.result import Calibration, Fit
from tatamu.calibration.setup import Setup, setup_of
from tatamu.calibration.target import Target, by_parameter, push_target, targets_of, weights
from tatamu.calibration.uncertainty import Slopes, contributions, disagreement, slopes
from tatamu.errors import InputError
from tatamu.material import Material
from tatamu.simulators import named

SAME = 5e-3
"""Parameters that change by less than this part from pass to pass agree."""
MOST_PASSES = 5
LIGHTEST, HEAVIEST = 0.02, 5.0
"""Areal densities that a fabric has [kg/m^2]."""
WRINKLE = ("native", "blender")
"""Simulators that know `Material.compression`."""
Groups = dict[str, list[Target]]
"""Parameter to the tests that tell it."""


def calibrate(
    measurements: Measurements,
    simulator: str = "native",
    spacing: float | None = None,
    tick: Callable[[str], None] = lambda what: None,
) -> Calibration:
    """Find the material with which a simulator gives the readings.

    Args:
        measurements: What was measured.
        simulator: Name of the simulator.
        spacing: Mesh spacing of the tests [m]; None: fine enough that it does not matter in `native`.
        tick: Called before each simulation with the name of its test.

    Raises:
        InputError: The garment or the simulator does not exist, or a reading is beyond the simulator.
        SimulationError: The simulator gave up on a test whatever the parameter.
    """
    named(simulator)
    setup, readings = setup_of(measurements, spacing), readings_of(measurements)
    laboratory, groups = Laboratory(simulator, tick), by_parameter(targets_of(setup, readings))
    material, matches, passes = _elastic(laboratory, groups, _start(setup, readings, groups))
    fits = [fit for group in groups.values() for fit in _fits(laboratory, group, matches, material)]
    shapes = {
        target.test.name: laboratory.shape(target.test, material) for group in groups.values() for target in group
    }
    sliding = None
    if setup.slope is not None:
        sliding = _friction(laboratory, setup.slope, material)
        material = material.model_copy(update={"friction_table": sliding.coefficient})
        fits.append(_friction_fit(setup.slope, sliding, readings))
    push = setup.push if simulator in WRINKLE else None
    if push is not None:
        target = push_target(push, material, readings)
        material, fit = _compression(laboratory, target, material)
        fits.append(fit)
        shapes[target.test.name] = laboratory.shape(target.test, material)
    return Calibration(
        material=material,
        simulator=simulator,
        setup=setup,
        fits=tuple(fits),
        contributions=_contributions(laboratory, setup, readings, groups, matches, material, sliding),
        readings=readings,
        assumed=_assumed(setup, push),
        shapes=shapes,
        passes=passes,
        simulations=laboratory.simulations,
        unsettled=laboratory.unsettled,
    )


def _start(setup: Setup, readings: dict[str, Reading], groups: Groups) -> Material:
    """The material before the first simulation: textbook guesses for what was measured."""
    density = readings["mass"].value / setup.area
    if not LIGHTEST <= density <= HEAVIEST:
        raise InputError(
            f"mass: {readings['mass'].value:g} kg over the garment's {setup.area:.3f} m² is {density:.3g} kg/m², but "
            f"fabrics weigh {LIGHTEST:g} to {HEAVIEST:g} kg/m²; are mass (kg) and size (m) those of this garment?"
        )
    guesses = {
        parameter: _mean(group, [target.start(density) for target in group]) for parameter, group in groups.items()
    }
    return setup.base.model_copy(update={"areal_density": density, **guesses})


def _elastic(laboratory: Laboratory, groups: Groups, material: Material) -> tuple[Material, dict[str, Match], int]:
    """Match the tests in turn until no parameter changes; the matches by test, and how many passes it took."""
    matches: dict[str, Match] = {}
    passes, before = 0, None
    while passes < MOST_PASSES and (before is None or _moved(material, before, groups)):
        passes, before = passes + 1, material
        for parameter, group in groups.items():
            for target in group:
                earlier = matches.get(target.test.name)
                start = earlier.parameter if earlier else getattr(material, parameter)
                found = target.matched(laboratory, material, start)
                matches[target.test.name] = found.after(earlier.samples if earlier else ())
            some = _told(group, matches) or group[-1:]
            value = _mean(some, [matches[target.test.name].parameter for target in some])
            material = material.model_copy(update={parameter: value})
    return material, matches, passes


def _mean(group: list[Target], values: list[float]) -> float:
    """A parameter from what each of its tests says alone: the mean of the logarithms, by `weights`."""
    return values[0] if len(values) == 1 else float(np.exp(weights(group) @ np.log(values)))


def _told(group: list[Target], matches: dict[str, Match]) -> list[Target]:
    """The tests of a group that tell the parameter, and do not only bound it."""
    return [target for target in group if target.bound_by(matches[target.test.name]) is None]


def _moved(material: Material, before: Material, groups: Groups) -> bool:
    """Whether a pass changed a parameter."""
    ratios = [getattr(material, parameter) / getattr(before, parameter) for parameter in groups]
    return any(abs(np.log(ratio)) > SAME for ratio in ratios)


def _fits(laboratory: Laboratory, group: list[Target], matches: dict[str, Match], material: Material) -> list[Fit]:
    """The tests of one parameter, as they read in the simulator with the material found."""
    if len(group) == 1:
        found = matches[group[0].test.name]
        return [_fit(group[0], found, found.reading)]
    return [
        _fit(target, matches[target.test.name], laboratory.reading(target.test, material), shared=True)
        for target in group
    ]


def _fit(target: Target, found: Match, simulated: float, shared: bool = False) -> Fit:
    """`shared`: what the test alone says is not all that decided the parameter."""
    return Fit(
        test=target.test.name,
        parameter=target.parameter,
        measured=target.measured,
        uncertainty=target.uncertainty,
        aim=target.aim,
        simulated=simulated,
        unit="m",
        bound=target.bound_by(found),
        samples=found.samples,
        alone=found.parameter if shared else None,
    )


def _compression(laboratory: Laboratory, target: Target, material: Material) -> tuple[Material, Fit]:
    """Search the part of Y that resists compression; cloth that is known to resist at least so much resists as before.

    A sheet that slides as a whole before a ruler gives no reason to think that it wrinkles where nobody looked.
    """
    found = target.matched(laboratory, material, target.start(material.areal_density))
    if target.bound_by(found) == "at least" and found.parameter < material.compression:
        return material, _fit(target, found, laboratory.reading(target.test, material), shared=True)
    return material.model_copy(update={"compression": found.parameter}), _fit(target, found, found.reading)


def _friction(laboratory: Laboratory, slope: Slope, material: Material) -> Sliding:
    """Search the coefficient on the simulated board."""

    def speed(coefficient: float) -> float:
        rollout = laboratory.run(slope.scene(material.model_copy(update={"friction_table": coefficient})), "friction")
        return slope.speed(rollout)

    return threshold(speed, slope.textbook)


def _friction_fit(slope: Slope, sliding: Sliding, readings: dict[str, Reading]) -> Fit:
    board, height = readings["L_t"], readings["H_s"]
    error = np.hypot(height.uncertainty, np.sin(slope.angle) * board.uncertainty) / (board.value * np.cos(slope.angle))
    return Fit(
        test="friction",
        parameter="friction_table",
        measured=slope.angle,
        uncertainty=float(error),
        aim=slope.angle,
        simulated=slope.angle,
        unit="rad",
        bound=sliding.bound,
        samples=sliding.samples,
    )


def _contributions(
    laboratory: Laboratory,
    setup: Setup,
    readings: dict[str, Reading],
    groups: Groups,
    matches: dict[str, Match],
    material: Material,
    sliding: Sliding | None,
) -> dict[str, np.ndarray]:
    """What each reading has to do with each parameter; what only bounds one has nothing to do with it."""

    def found(target: Target) -> Slopes:
        def reading(stretch: float, bending: float) -> float:
            changed = {"stretch_stiffness": float(np.exp(stretch)), "bending_rigidity": float(np.exp(bending))}
            return laboratory.reading(target.test, material.model_copy(update=changed))

        return slopes(reading, (float(np.log(material.stretch_stiffness)), float(np.log(material.bending_rigidity))))

    elongation = next((found(target) for target in _told(groups.get("stretch_stiffness", []), matches)), None)
    both = _told(groups.get("bending_rigidity", []), matches)
    bending = {
        target.test.name: (float(weight), found(target)) for target, weight in zip(both, weights(both), strict=True)
    }
    friction = None
    if setup.slope is not None and sliding is not None:
        friction = setup.slope.angle, readings["L_t"].value, (sliding.sticks - sliding.slides) / sliding.coefficient
    made = contributions(readings, elongation, bending, friction)
    apart = disagreement([matches[target.test.name].parameter for target in both], [target.spread for target in both])
    if apart:
        made["disagreement"] = np.array([0.0, 0.0, apart, 0.0, 0.0])
    return made


def _assumed(setup: Setup, push: Push | None) -> tuple[str, ...]:
    """Fields that nothing measured; `push` is None where it was not made, or not used."""
    made = {
        "stretch_stiffness": setup.elongation,
        "bending_rigidity": setup.sag or setup.loop,
        "friction_table": setup.slope,
        "compression": push,
    }
    return (*(name for name, test in made.items() if test is None), "poisson_ratio", "friction_cloth", "air_drag")
