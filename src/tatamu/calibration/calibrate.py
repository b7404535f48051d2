"""Calibration: find the parameters of one simulator from measurements (paper, section IV).

Stretch stiffness, bending rigidity and friction of bending are found in turn, each from its own tests with the other
two fixed, until none of the three changes. Several tests of one parameter give the weighted mean of their values. The
tests that need these parameters come later, in the order of `measurements.TESTS`.

Every parameter is an effective value, with which this simulator reproduces the readings on meshes like those of the
tests.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import InputError
from tatamu.calibration.estimate import Fit
from tatamu.calibration.laboratory import DEFAULTS, CalibrationOptions, Laboratory
from tatamu.calibration.match import Match
from tatamu.calibration.measurements import Measurements
from tatamu.calibration.parameters import OPTIONAL, PARAMETERS, PLACE, UNMEASURED
from tatamu.calibration.result import Calibration
from tatamu.calibration.setup import Setup, setup_of
from tatamu.calibration.test import CalibrationTest, Changes, ElasticTest, LaterTest, Readings, Target
from tatamu.calibration.uncertainty import ELASTIC, Sensitivity, contributions, disagreement, slopes
from tatamu.simulation.material import Material
from tatamu.simulation.simulators import named

Groups = dict[str, list[Target]]
"""The targets of each parameter."""


def calibrate(
    measurements: Measurements,
    simulator: str = "native",
    spacing: float | None = None,
    tick: Callable[[str], None] = lambda what: None,
    options: CalibrationOptions = DEFAULTS,
) -> Calibration:
    """Find the material with which a simulator reproduces the readings.

    Args:
        measurements: Readings of the garment.
        simulator: Name of the simulator.
        spacing: Mesh spacing of the tests [m]; None for a mesh so fine that it does not matter in `native`.
        tick: Function that is called before each simulation with the name of its test.
        options: Accuracy of the matches, and durations.

    Raises:
        InputError: If the garment or the simulator does not exist, or the simulator cannot reproduce a reading.
        SimulationError: If the simulator fails for every value of a test's parameter.
    """
    named(simulator)
    setup = setup_of(measurements, spacing)
    readings = measurements.readings()
    tests = setup.usable(simulator)
    laboratory = Laboratory(simulator, tick, options)
    groups = by_parameter([test.target(readings) for test in tests if isinstance(test, ElasticTest)])
    elastic = _elastic(laboratory, groups, _start(setup, readings, groups))
    material = elastic.material
    fits = [fit for group in groups.values() for fit in elastic.fits(laboratory, group)]
    shapes: dict[str, np.ndarray | None] = {}
    for target in (each for group in groups.values() for each in group):
        laboratory.reading(target.test, material)
        shapes[target.test.name] = laboratory.shape(target.test.name, material)
    for test in tests:
        if not isinstance(test, LaterTest):
            continue
        material, fit = test.find(laboratory, material, readings)
        fits.append(fit)
        shapes[test.name] = laboratory.shape(test.name, material)
    measured = {"areal_density", *OPTIONAL, *(test.parameter for test in tests)}
    assumed = [name for name in PARAMETERS if name not in measured]
    return Calibration(
        material=material,
        simulator=simulator,
        setup=setup,
        fits=tuple(fits),
        contributions=_contributions(laboratory, readings, tests, elastic, fits, material),
        readings=readings,
        assumed=(*assumed, *UNMEASURED, *setup.assumed),
        shapes=shapes,
        passes=elastic.passes,
        simulations=laboratory.simulations,
        unsettled=laboratory.unsettled,
    )


@dataclass(frozen=True)
class ElasticMatch:
    """Results of the searches for stretch stiffness, bending rigidity and friction of bending."""

    material: Material
    groups: Groups
    matches: dict[str, Match]
    """Result of each test's search, by the name of the test."""
    passes: int

    def fits(self, laboratory: Laboratory, group: list[Target]) -> list[Fit]:
        """Return the result of each test of one parameter, with readings simulated with the material that was found."""
        if len(group) == 1:
            found = self.matches[group[0].test.name]
            return [group[0].fit(found, found.reading)]
        return [
            target.fit(self.matches[target.test.name], laboratory.reading(target.test, self.material), shared=True)
            for target in group
        ]


def _start(setup: Setup, readings: Readings, groups: Groups) -> Material:
    """Return the material with which the search starts, by textbook formulas."""
    density = readings["mass"].value / setup.area
    if not 0.02 <= density <= 5.0:
        raise InputError(
            f"mass: must be 0.02 to 5 kg per m² of cloth, given {density:.3g} kg/m² ({readings['mass'].value:g} kg on "
            f"{setup.area:.3f} m²); check the mass [kg] and the size [m] of the garment"
        )
    material = setup.base.model_copy(update={"areal_density": density})
    guesses = {
        parameter: _mean(group, [target.start(material) for target in group]) for parameter, group in groups.items()
    }
    return material.model_copy(update=guesses)


def _elastic(laboratory: Laboratory, groups: Groups, material: Material) -> ElasticMatch:
    """Find stretch stiffness, bending rigidity and friction of bending in turn, and repeat this until none changes."""
    matches: dict[str, Match] = {}
    passes = 0
    before: Material | None = None
    rubs = "bending_hysteresis" in groups
    options = laboratory.options
    most = options.passes_with_friction if rubs else options.passes
    while passes < most and (before is None or _moved(material, before, groups, options.agreement)):
        passes += 1
        before = material
        for parameter, group in groups.items():
            for target in group:
                earlier = matches.get(target.test.name)
                start = earlier.parameter if earlier else getattr(material, parameter)
                found = target.matched(laboratory, material, start)
                alike = not rubs or len(found.samples) < 2  # otherwise, samples of earlier passes lie on another curve
                matches[target.test.name] = found.after(earlier.samples if earlier and alike else ())
            some = _telling(group, matches) or group[-1:]
            value = _mean(some, [matches[target.test.name].parameter for target in some])
            material = material.model_copy(update={parameter: value})
    return ElasticMatch(material, groups, matches, passes)


def _mean(group: list[Target], values: list[float]) -> float:
    """Return the weighted geometric mean of the values that several tests give for a parameter."""
    return values[0] if len(values) == 1 else float(np.exp(weights(group) @ np.log(values)))


def _telling(group: list[Target], matches: dict[str, Match]) -> list[Target]:
    """Return the tests of one parameter that do not only bound it."""
    return [target for target in group if target.bound_by(matches[target.test.name]) is None]


def _moved(material: Material, before: Material, groups: Groups, agreement: float) -> bool:
    """Return whether the last pass over the tests changed the logarithm of a parameter by more than `agreement`."""
    ratios = [getattr(material, parameter) / getattr(before, parameter) for parameter in groups]
    return any(abs(np.log(ratio)) > agreement for ratio in ratios)


def _contributions(
    laboratory: Laboratory,
    readings: Readings,
    tests: list[CalibrationTest],
    elastic: ElasticMatch,
    fits: list[Fit],
    material: Material,
) -> Changes:
    """Return how much each reading of a test that determines a parameter contributes to the uncertainties."""

    def sensitivity(target: Target, weight: float) -> Sensitivity:
        def reading(*logarithms: float) -> float:
            changed = {name: float(np.exp(value)) for name, value in zip(known, logarithms, strict=True)}
            return laboratory.reading(target.test, material.model_copy(update=changed))

        test = target.test
        assert isinstance(test, ElasticTest)
        at = tuple(float(np.log(getattr(material, name))) for name in known)
        along = slopes(reading, at, test.step)
        return Sensitivity(test, weight, along, test.chance(laboratory.shapes(test.name)))

    known = [name for name in ELASTIC if name not in OPTIONAL or elastic.groups.get(name)]
    telling = {parameter: _telling(elastic.groups.get(parameter, []), elastic.matches) for parameter in ELASTIC}
    sensitivities = [
        sensitivity(target, float(weight))
        for group in telling.values()
        for target, weight in zip(group, weights(group), strict=True)
    ]
    by_test = {fit.test: fit for fit in fits}
    later = [(test, by_test[test.name]) for test in tests if isinstance(test, LaterTest)]
    made = contributions(readings, sensitivities, later)
    for parameter, group in telling.items():
        alone = [elastic.matches[target.test.name].parameter for target in group]
        apart = disagreement(alone, [target.spread for target in group])
        if apart:
            made.setdefault("disagreement", np.zeros(len(PARAMETERS)))[PLACE[parameter]] = apart
    return made


def by_parameter(targets: list[Target]) -> dict[str, list[Target]]:
    """Group tests by their parameters. Tests that only bound a parameter are left out if another test determines it."""
    groups: dict[str, list[Target]] = {}
    for target in targets:
        groups.setdefault(target.parameter, []).append(target)
    return {
        parameter: [target for target in group if target.bound is None] or group[-1:]
        for parameter, group in groups.items()
    }


def weights(group: list[Target]) -> np.ndarray:
    """Return the weights of the k tests of one parameter, `Target.spread` to the power of -2 with sum 1, shape (k,)."""
    inverse = np.array([target.spread**-2.0 for target in group])
    return np.asarray(inverse / inverse.sum())
