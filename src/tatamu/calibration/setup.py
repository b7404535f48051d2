"""The simulated copy of the measured garment, and the tests that were made on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from tatamu.calibration.measurements import TESTS, Measurements
from tatamu.calibration.test import CalibrationTest, Specimen
from tatamu.garments import GARMENTS, Garment, make_garment
from tatamu.simulation.material import Material, load_material
from tatamu.simulation.mesh.topology import areas


@dataclass(frozen=True)
class Setup:
    """The simulated copies of a measured garment and of the tests that were made on it."""

    garment: Garment
    """The garment that was measured."""
    base: Material
    """The material before the calibration."""
    tests: Mapping[str, CalibrationTest]
    """Tests by their names, in the order of `TESTS`."""
    assumed: tuple[str, ...] = ()
    """Fields of the material that the measurements file may state, but does not state."""

    @property
    def area(self) -> float:
        """Area of all layers of the garment together [m^2]."""
        return float(areas(self.garment.cloth().rest, self.garment.faces).sum())

    def usable(self, simulator: str) -> list[CalibrationTest]:
        """Return the tests that a simulator can do and no other test replaces."""
        return [test for test in self.tests.values() if self.unused(test, simulator) is None]

    def unused(self, test: CalibrationTest, simulator: str) -> str | None:
        """Return why a test is not used with a simulator; None if it is used."""
        why = test.unusable(simulator)
        if why is not None:
            return f"{simulator} {why}"
        made = [self.tests[name] for name in test.yields_to if name in self.tests]
        if any(other.unusable(simulator) is None for other in made):
            return f"as {test.texts['yields_because']}"
        return None


def setup_of(measurements: Measurements, spacing: float | None = None) -> Setup:
    """Make the simulated copies of the tests in a measurements file.

    Raises:
        InputError: If the garment, its material or an edge does not exist, or the garment cannot have these readings.
    """
    given = measurements.garment
    material = load_material(Path(given.material)) if given.material else None
    if material is not None and given.thickness:
        material = material.model_copy(update={"thickness": given.thickness})
    garment = make_garment(given.name, given.size, material, spacing or (0.02 if given.name in GARMENTS else None))
    thick = {"thickness": given.thickness} if given.thickness else {}
    base = garment.material.model_copy(update={**thick, "blender": None, "bending_rigidity_initial": None})
    specimen = Specimen(garment, base, spacing)
    made = {name: TESTS[name].of(entry, specimen) for name, entry in measurements.entries().items()}
    assumed = () if given.thickness else ("thickness",)
    return Setup(garment, base, made, assumed)
