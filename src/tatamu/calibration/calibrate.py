"""Calibration: measurements in, the parameters of one simulator out (paper, section IV).

Areal density is mass over area. Stretch stiffness and bending rigidity are matched in turn, each in its own test with
the other as it stands, until both stay; friction does not touch those tests, and is searched once they are done, and
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
from tatamu.calibration.target import Target, parted, push_target, targets_of
from tatamu.calibration.uncertainty import Slopes, contributions, slopes
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
    laboratory, (targets, checks) = Laboratory(simulator, tick), parted(targets_of(setup, readings))
    material, matches, passes = _elastic(laboratory, targets, _start(setup, readings, targets))
    fits = [_fit(target, found.reading, found) for target in targets for found in [matches[target.parameter]]]
    fits += [_fit(target, laboratory.reading(target.test, material)) for target in checks]
    told = [target for target in targets if target.bound_by(matches[target.parameter]) is None]
    shapes = {target.test.name: laboratory.shape(target.test, material) for target in [*targets, *checks]}
    sliding = None
    if setup.slope is not None:
        sliding = _friction(laboratory, setup.slope, material)
        material = material.model_copy(update={"friction_table": sliding.coefficient})
        fits.append(_friction_fit(setup.slope, sliding, readings))
    push = setup.push if simulator in WRINKLE else None
    if push is not None:
        target = push_target(push, material, readings)
        found = target.matched(laboratory, material, target.start(material.areal_density))
        material = material.model_copy(update={"compression": found.parameter})
        fits.append(_fit(target, found.reading, found))
        shapes[target.test.name] = laboratory.shape(target.test, material)
    return Calibration(
        material=material,
        simulator=simulator,
        setup=setup,
        fits=tuple(fits),
        contributions=_contributions(laboratory, setup, readings, told, material, sliding),
        readings=readings,
        assumed=_assumed(setup, push),
        shapes=shapes,
        passes=passes,
        simulations=laboratory.simulations,
        unsettled=laboratory.unsettled,
    )


def _start(setup: Setup, readings: dict[str, Reading], targets: list[Target]) -> Material:
    """The material before the first simulation: textbook guesses for what was measured."""
    density = readings["mass"].value / setup.area
    if not LIGHTEST <= density <= HEAVIEST:
        raise InputError(
            f"mass: {readings['mass'].value:g} kg over the garment's {setup.area:.3f} m² is {density:.3g} kg/m², but "
            f"fabrics weigh {LIGHTEST:g} to {HEAVIEST:g} kg/m²; are mass (kg) and size (m) those of this garment?"
        )
    guesses = {target.parameter: target.start(density) for target in targets}
    return setup.base.model_copy(update={"areal_density": density, **guesses})


def _elastic(
    laboratory: Laboratory, targets: list[Target], material: Material
) -> tuple[Material, dict[str, Match], int]:
    """Match the targets in turn until no parameter changes; the matches by parameter, and how many passes it took."""
    matches: dict[str, Match] = {}
    passes, before = 0, None
    while passes < MOST_PASSES and (before is None or _moved(material, before, targets)):
        passes, before = passes + 1, material
        for target in targets:
            found = target.matched(laboratory, material, getattr(material, target.parameter))
            earlier = matches[target.parameter].samples if target.parameter in matches else ()
            matches[target.parameter] = found.after(earlier)
            material = material.model_copy(update={target.parameter: found.parameter})
    return material, matches, passes


def _moved(material: Material, before: Material, targets: list[Target]) -> bool:
    """Whether a pass changed a parameter."""
    ratios = [getattr(material, target.parameter) / getattr(before, target.parameter) for target in targets]
    return any(abs(np.log(ratio)) > SAME for ratio in ratios)


def _fit(target: Target, simulated: float, found: Match | None = None) -> Fit:
    """A test and what it reads in the simulator; without a search it is a check: another test told its parameter."""
    return Fit(
        test=target.test.name,
        parameter=target.parameter,
        measured=target.measured,
        uncertainty=target.uncertainty,
        aim=target.aim,
        simulated=simulated,
        unit="m",
        bound=target.bound_by(found) if found else target.bound,
        samples=found.samples if found else (),
        check=found is None,
    )


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
    targets: list[Target],
    material: Material,
    sliding: Sliding | None,
) -> dict[str, np.ndarray]:
    """What each reading has to do with each parameter; `targets` are those whose readings tell one."""
    found: dict[str, Slopes] = {}
    for target in targets:

        def reading(stretch: float, bending: float, target: Target = target) -> float:
            changed = {"stretch_stiffness": float(np.exp(stretch)), "bending_rigidity": float(np.exp(bending))}
            return laboratory.reading(target.test, material.model_copy(update=changed))

        at = float(np.log(material.stretch_stiffness)), float(np.log(material.bending_rigidity))
        found[target.test.name] = slopes(reading, at)
    friction = None
    if setup.slope is not None and sliding is not None:
        friction = setup.slope.angle, readings["L_t"].value, (sliding.sticks - sliding.slides) / sliding.coefficient
    bending = next(((name, found[name]) for name in ("sag", "loop") if name in found), None)
    return contributions(readings, found.get("elongation"), bending, friction)


def _assumed(setup: Setup, push: Push | None) -> tuple[str, ...]:
    """Fields that nothing measured; `push` is None where it was not made, or not used."""
    made = {
        "stretch_stiffness": setup.elongation,
        "bending_rigidity": setup.sag or setup.loop,
        "friction_table": setup.slope,
        "compression": push,
    }
    return (*(name for name, test in made.items() if test is None), "poisson_ratio", "friction_cloth", "air_drag")
