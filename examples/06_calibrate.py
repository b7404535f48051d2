"""Calibrate the simulator to the readings of a towel, and see which reading to repeat.

python examples/06_calibrate.py
"""

from __future__ import annotations

from pathlib import Path

from tatamu.calibration import advice_on, calibrate, load_measurements

READINGS = Path(__file__).with_name("measurements-towel.toml")


def main() -> float:
    found = calibrate(load_measurements(READINGS))
    material = found.material
    print(f"Y = {material.stretch_stiffness:.0f} ± {found.uncertainty('stretch_stiffness'):.0f} N/m")
    print(f"B = {1e6 * material.bending_rigidity:.0f} ± {1e6 * found.uncertainty('bending_rigidity'):.0f} µN m")
    print(f"μ = {material.friction_table:.2f} ± {found.uncertainty('friction_table'):.2f}")
    print("\n".join(advice_on(found)))
    return material.bending_length


if __name__ == "__main__":
    main()
