"""Finds the bending rigidity with which the simulator `native` would reproduce the measured drape of each fabric.

    python -m studies.real_cloth.asked_rigidity --data DATA --out runs/real-cloth

The fabrics are the fabrics of the test "drape". The model of the fabrics is the one that this test compares with its
goals. All rigidities of a fabric are multiplied by a factor. The hysteresis of the fabric is not changed. The factor
that gives the measured drape coefficient is found by interpolation. This factor helps to explain the error of a
prediction. It is not used in predictions.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from benchmarks.tables import markdown

from studies.real_cloth import drape
from studies.real_cloth.bench import Bench
from studies.real_cloth.drape import Draped
from studies.real_cloth.matsudaira import DrapeModel, Matsudaira, MeasuredDrape, judged, models

FACTORS = (0.35, 0.5, 0.7, 0.85, 1.0, 1.3)
"""Factors by which the measured bending rigidity of a fabric is multiplied."""
SIMULATOR = "native"
Row = dict[str, str]


def swept(each: MeasuredDrape, model: DrapeModel, bench: Bench) -> list[Draped]:
    """Simulate the drape of a fabric whose bending rigidity is multiplied by each factor in `FACTORS`."""
    groups = [
        drape.experiments(
            f"{each.fabric.name}, {factor:g} times as stiff",
            model.material(replace(each.fabric, bending=factor * each.fabric.bending)),
            model.size,
            bench.seeds,
            model.waviness,
        )
        for factor in FACTORS
    ]
    values = bench.measure([experiment for group in groups for experiment in group])
    return [Draped.of(values[k : k + bench.seeds], model.size) for k in range(0, len(values), bench.seeds)]


def asked(coefficient: float, drapes: Sequence[Draped]) -> str:
    """Return the factor of the bending rigidity for which the simulated drape has a given drape coefficient, as text.

    If the factor is outside the range of the simulations, the text has a bound, such as "below 0.35".
    """
    means = np.maximum.accumulate([drawn.mean for drawn in drapes])
    if coefficient < means[0]:
        return f"below {FACTORS[0]:g}"
    if coefficient > means[-1]:
        return f"above {FACTORS[-1]:g}"
    return f"{np.exp(np.interp(coefficient, means, np.log(FACTORS))):.2f}"


def row(each: MeasuredDrape, drapes: Sequence[Draped]) -> Row:
    """Return the line of the table for a fabric: its drape for each factor, and the factor that fits."""
    means = {f"{factor:g} B": f"{drawn.mean:.1f}" for factor, drawn in zip(FACTORS, drapes, strict=True)}
    return {
        "fabric": f"{each.fabric.name} {each.fabric.kind}",
        "measured [%]": f"{each.coefficient:.1f}",
        **means,
        "B asked for, over the measured": asked(each.coefficient, drapes),
    }


def main() -> None:
    """Parse the command line, simulate the drapes, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    bench = Bench(SIMULATOR, options.out / "kept", tick=lambda label: print(label, flush=True))
    known = models(SIMULATOR)
    model = known[judged(known)]
    table = markdown([row(each, swept(each, model, bench)) for each in Matsudaira().load(options.data)])
    print(table)


if __name__ == "__main__":
    main()
